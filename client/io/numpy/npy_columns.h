// Makes columns of an array that numpy has saved.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/numpy/npy_header.h"
#include "client/io/point_table.h"

namespace curv {

// Appends the columns of an array whose first dimension counts points: shape (N,) is one column `name`, shape (N, 3)
// three of them (positions, points and xyz are x y z; normals and normal are nx ny nz; any other name gets x, y and z
// at its end), shape (N, K) K of them, NAME_0 and so on. Fields of structured arrays count as arrays of their names.
// Integers of 64 bits become doubles. What has no place in a table is told in `notes`.
// REQUIRES: `header` is that of `file`; its shape has one or two dimensions, one if it is structured.
void AppendColumns(std::string_view file, const NpyHeader& header, const std::string& name,
                   std::vector<Column>& columns, std::vector<std::string>& notes);

// The names of `count` columns of one array of that name, as above.
std::vector<std::string> ColumnNamesOf(const std::string& name, uint64_t count);

}  // namespace curv
