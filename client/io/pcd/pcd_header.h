// Reads the header of a PCD file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/pcd/pcd_frame.h"

namespace curv {

struct PcdField {
  std::string name;
  char type = 'F';  // I, U or F
  uint32_t bytes = 4;
  uint32_t count = 1;

  size_t row_bytes() const { return size_t{bytes} * count; }
  // Returns whether a table has a place for the field.
  bool kept() const { return count == 1 && name != "_"; }
};

struct PcdHeader {
  std::vector<PcdField> fields;  // of 1, 2, 4 or 8 bytes; at most 65,536 values in a row
  uint64_t points;
  std::optional<std::array<double, 3>> viewpoint;  // unless it is 0 0 0, which is what writers say who do not know it
  PcdFrame frame;
  std::string encoding;  // the word after DATA, which may be none that is known
  size_t lines;
  std::string_view body;  // the bytes after the header
};

// Reads the header of the file that `bytes` holds. INVALID_ARGUMENT naming the line if it is not one of PCD 0.5 to 0.7.
absl::StatusOr<PcdHeader> ReadPcdHeader(std::string_view bytes);

}  // namespace curv
