// Writes a file from tables that come one after the other, so that the file may be larger than memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/io/table_file.h"

namespace curv {

// The bytes are those that SaveTable writes of one table with all the rows. Not thread-safe.
class TableStream {
 public:
  // Returns whether a file of that name can be written so: PLY, PCD, XYZ, CSV and NPY can, packed or not; LAS and NPZ
  // are written of whole tables only.
  static bool CanWrite(const std::string& path, const SaveOptions& options);

  // Starts a file with the columns of `like`, whose rows are not written, and `rows` rows. Errors are those of
  // SaveTable. REQUIRES: CanWrite.
  static absl::StatusOr<std::unique_ptr<TableStream>> Create(const std::string& path, const SaveOptions& options,
                                                             const PointTable& like, uint64_t rows);
  virtual ~TableStream() = default;

  // Appends the rows of a table. REQUIRES: it has the columns of `like`, in their order.
  virtual absl::Status Append(const PointTable& table) = 0;

  // Makes the file appear, as AtomicFile::Commit; without it, nothing is written. REQUIRES: `rows` rows were appended.
  virtual absl::Status Commit() = 0;
};

}  // namespace curv
