// Reads the header of a PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// What CloudCompare puts before the names of properties that it keeps as scalar fields.
inline constexpr std::string_view kScalarPrefix = "scalar_";

enum class PlyFormat : uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  ScalarKind kind;                       // of the value, or of the list's items
  std::optional<ScalarKind> count_kind;  // of the list's length; none for a scalar
};

struct PlyElement {
  std::string name;
  uint64_t count;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  // Returns the bytes of one binary row; where there are lists, the fewest that a row can take.
  size_t min_row_bytes() const;
};

struct PlyHeader {
  PlyFormat format;
  std::vector<PlyElement> elements;
  size_t bytes;  // of the header, with the line end after end_header
  size_t lines;
};

// Reads the header at the beginning of `bytes`. INVALID_ARGUMENT naming the line if it is not one of PLY 1.0.
absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes);

// Returns the name that a scalar type has in the headers that we write.
std::string_view PlyTypeName(ScalarKind kind);

}  // namespace curv
