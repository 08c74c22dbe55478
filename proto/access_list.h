// Reads the files that say who may call: names, hashes of tokens, and limits of each.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace curvd {

using Sha256 = std::array<uint8_t, 32>;

Sha256 HashToken(std::string_view token);
// "sha256:" and 64 digits, as it stands in a token file.
std::string FormatHash(const Sha256& hash);

// One line of such a file.
struct AccessEntry {
  std::string name;          // of the caller, for logs and limits; several lines may share one
  Sha256 token_hash{};       // of a token file only
  uint32_t max_streams = 0;  // calls that the caller may have open; 0: no limit of its own
  uint64_t max_points = 0;   // points in one of its clouds; 0: no limit of its own
};

// Reads lines of
//   NAME sha256:HEX [max-streams=N] [max-points=N]
// (without the hash for a list of names). Words are set apart by blanks; empty lines and lines that begin with # are
// left out. INVALID_ARGUMENT, naming the line's number and what is wrong with it but never quoting a hash (somebody may
// have put the token itself there), if a line is none of these. A file without an entry lets nobody in.
absl::StatusOr<std::vector<AccessEntry>> ParseTokenFile(std::string_view text);
absl::StatusOr<std::vector<AccessEntry>> ParseNameFile(std::string_view text);

}  // namespace curvd
