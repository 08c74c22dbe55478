// Reads vectors from three columns of a table, and orients its normals.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/io/point_table.h"
#include "client/surfaces/vec3.h"

namespace curv {

// Returns the columns prefix + x, y and z as vectors. REQUIRES: the table has them.
std::vector<Vec3> VectorsOf(const PointTable& table, const std::string& prefix);

// Orients the normals of the table on `threads` threads, see OrientNormals, and returns how many were negated.
// REQUIRES: ExtractCloud succeeds on the table; threads >= 0.
size_t OrientTable(PointTable& table, int threads);

}  // namespace curv
