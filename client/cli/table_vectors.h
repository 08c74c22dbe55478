// Reads vectors from three columns of a table, and turns its normals.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/io/point_table.h"
#include "client/surfaces/vec3.h"

namespace curv {

// Returns the columns prefix + x, y and z as vectors. REQUIRES: the table has them.
std::vector<Vec3> VectorsOf(const PointTable& table, const std::string& prefix);

// Negates the normals of the table that point against `normals`, x y z of each point, and returns how many. Others stay
// as they are, to the last digit; so do those whose counterpart is not a number. REQUIRES: ExtractCloud succeeds on the
// table; as many normals as it has points.
size_t TurnTable(const std::vector<float>& normals, PointTable& table);

}  // namespace curv
