// Orders positions so that those that are close in space are close in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// Returns the indices of the positions along a Morton curve through their bounding box; within one of its cells (1,024
// along the longest axis), in ascending order.
// REQUIRES: positions are finite, fewer than 2^32.
std::vector<uint32_t> SpatialOrder(const std::vector<Vec3>& positions);

}  // namespace curv
