// How far apart points are, each from its neighbors.
#pragma once

#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// Distance from each position to its `rank`-th nearest other position; less than that many others: to the farthest; 0
// if there is no other. REQUIRES: positions are finite, rank in [1, 32].
std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank);

}  // namespace curv
