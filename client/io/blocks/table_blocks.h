// Reads the points of a file some at a time, so that a file may be larger than memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// Binary PLY whose vertices come first and have no lists, uncompressed binary PCD, LAS, NPY (but for matrices in
// Fortran order), CSV and text are read block by block; other files, among them all that gzip has packed, as a whole,
// if they fit. Not thread-safe.
class TableBlocks {
 public:
  // Opens a file as LoadTable does, but for standard input, which cannot be read twice. Blocks take about
  // `block_bytes` of the file; a file that is read as a whole may have `most_bytes`. INVALID_ARGUMENT if it cannot be
  // read, has no known format, or is shorter than it says; RESOURCE_EXHAUSTED naming the limit, and what would help, if
  // it would have to be read as a whole, and is too large for that.
  static absl::StatusOr<std::unique_ptr<TableBlocks>> Open(const std::string& path, const std::string& format,
                                                           uint64_t block_bytes, uint64_t most_bytes);
  virtual ~TableBlocks() = default;

  // The next points, as LoadTable would have them, in the order of the file; an empty table at the end. The first block
  // tells in its notes what was left out. INVALID_ARGUMENT naming the file if it is not what its format says; in text,
  // lines are counted from the start of the block, which the message names.
  virtual absl::StatusOr<PointTable> Next() = 0;

  // Whether the file is read as a whole.
  virtual bool is_whole() const = 0;
};

}  // namespace curv
