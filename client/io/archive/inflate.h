// Unpacks and packs bytes with zlib.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace curv {

// Unpacks raw deflated bytes, as they lie in zip archives, of which `bytes` must come out. INVALID_ARGUMENT, to be read
// after the name of what was packed, if they are damaged or give another number; nothing is allocated that deflate
// could not have packed into them.
absl::StatusOr<std::string> InflateRaw(std::string_view packed, uint64_t bytes);

// Returns whether these are the first bytes of a gzip file.
bool IsGzip(std::string_view bytes);

// Unpacks a gzip file (RFC 1952), of several members too. INVALID_ARGUMENT if it is damaged or cut off, or unpacks to
// more than `most_bytes`, of which no more than that is allocated.
absl::StatusOr<std::string> Gunzip(std::string_view packed, uint64_t most_bytes);

}  // namespace curv
