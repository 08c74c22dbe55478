// Says where the points of a binary file lie, so that some of them can be read without the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace curv {

// A file whose points are rows of equal size, one after the other. The bytes of start(n) followed by those of any n
// successive rows are a file of the same format that holds these n points.
struct RowLayout {
  uint64_t rows = 0;
  uint64_t rows_at = 0;  // byte of the first row
  size_t row_bytes = 0;
  std::function<std::string(uint64_t rows)> start;
};

// How many bytes of a file the functions below want to see at least, if it has so many.
inline constexpr size_t kLayoutBytes = 1 << 20;

// Each takes the start of a file, and returns the layout of its points. Nothing if they are no rows of equal size
// (text, lists, compressed or Fortran order), or if the start is not one of the format: the format's reader tells why.
std::optional<RowLayout> PlyLayout(std::string_view start);
std::optional<RowLayout> PcdLayout(std::string_view start);
std::optional<RowLayout> NpyLayout(std::string_view start);
// Also nothing if `start` does not hold all that stands before the points; LasPointsAt says how much that is.
std::optional<RowLayout> LasLayout(std::string_view start);
// The byte of a LAS file's first point; 0 if `start` is too short to tell.
uint64_t LasPointsAt(std::string_view start);

}  // namespace curv
