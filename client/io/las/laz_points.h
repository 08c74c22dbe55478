// Decompresses the points of LAZ and COPC files by lazperf, where the build found it (docs/files.md, "LAS").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace curv {

// Whether this program was built with lazperf.
bool CanReadLaz();

// Checks what decompressors take on trust: that the table of chunks lies in the file, behind the start of the points,
// has no more chunks than the file has bytes, and, where all chunks are of `chunk_points` points, as many as the points
// take. INVALID_ARGUMENT naming what is wrong. `chunk_points` is 0 where that is not known. REQUIRES: ReadLasHeader
// succeeds; the header tells of so many points.
absl::Status CheckChunkTable(std::string_view file, uint64_t points, uint32_t chunk_points);

// Gives the records of a compressed file in their order, as an uncompressed file would hold them. One thread at a time.
class LazPoints {
 public:
  virtual ~LazPoints() = default;

  // Opens a whole file, which must outlive the result, of which the header says that it has `points` records of
  // `record_bytes` each. UNIMPLEMENTED unless CanReadLaz(); INVALID_ARGUMENT if lazperf finds another count or length,
  // or no table of compressed chunks that holds so many points.
  static absl::StatusOr<std::unique_ptr<LazPoints>> Open(std::string_view file, uint64_t points, size_t record_bytes);

  // Writes the next `count` records to `records`. INVALID_ARGUMENT, naming the record, if they cannot be decompressed.
  // REQUIRES: so many are left.
  virtual absl::Status Next(size_t count, char* records) = 0;
};

}  // namespace curv
