// Reads and writes zip archives (PKWARE APPNOTE 6.3), as far as numpy needs them: members that are stored or deflated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/byte_sink.h"

namespace curv {

struct ZipMember {
  std::string name;
  uint16_t method = 0;  // 0: stored, 8: deflated
  uint32_t crc = 0;
  uint64_t packed_bytes = 0;
  uint64_t bytes = 0;
  uint64_t at = 0;  // of the local header
};

// Reads the directory of an archive; at most kMaxColumns members. INVALID_ARGUMENT if it is none, or the members
// together would take more bytes than it has.
absl::StatusOr<std::vector<ZipMember>> ReadZipDirectory(std::string_view archive);

// Returns the bytes of a member, checked by its sum. INVALID_ARGUMENT naming the member if it is damaged, encrypted or
// packed in another way. Allocates no more than deflate could have packed into the member.
absl::StatusOr<std::string> ReadZipMember(std::string_view archive, const ZipMember& member);

// Appends an archive of stored members to a file, with sizes of 64 bits where they are needed. Not thread-safe.
class ZipWriter {
 public:
  explicit ZipWriter(ByteSink& file) : file_(file) {}

  // Starts a member of so many bytes with that sum (Crc32). REQUIRES: exactly these bytes are appended next.
  absl::Status Begin(const std::string& name, uint64_t bytes, uint32_t crc);
  absl::Status Append(std::string_view bytes);
  // Appends the directory. Called once, at the end.
  absl::Status End();

 private:
  ByteSink& file_;
  uint64_t at_ = 0;
  std::vector<ZipMember> members_;
};

// Continues the CRC-32 of zip over more bytes; starts with 0.
uint32_t Crc32(uint32_t crc, std::string_view bytes);

}  // namespace curv
