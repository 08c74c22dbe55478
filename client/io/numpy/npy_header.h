// Reads the header of an array that numpy has saved (numpy.lib.format, versions 1.0 to 3.0).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace curv {

// A scalar, or an array of scalars, within each element.
struct NpyField {
  std::string name;             // empty if the array has no fields
  char sort = 'f';              // f, i, u, b (bool), or another that a table has no column for
  size_t bytes = 8;             // of one scalar
  bool swap = false;            // whether its bytes are in big-endian order
  std::vector<uint64_t> shape;  // empty: one scalar
  uint64_t scalars = 1;         // the product of the shape
  size_t offset = 0;            // bytes from the start of an element

  // Returns whether a table has columns for such scalars.
  bool kept() const;
};

struct NpyHeader {
  std::vector<NpyField> fields;  // one without a name, or those of a structured array
  bool structured = false;
  bool fortran_order = false;
  std::vector<uint64_t> shape;
  uint64_t elements = 1;  // the product of the shape
  size_t element_bytes = 0;
  size_t array_at = 0;  // byte of the first element; elements * element_bytes follow it
};

// Reads the header of a whole .npy file. INVALID_ARGUMENT naming what is wrong; also if the file is shorter than the
// array, or if the array holds Python objects.
absl::StatusOr<NpyHeader> ReadNpyHeader(std::string_view file);

// Returns a shape as numpy writes it: "(2, 3)".
std::string ShapeText(const std::vector<uint64_t>& shape);

}  // namespace curv
