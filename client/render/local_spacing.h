// Measures how far each point is from its neighbors.
#pragma once

#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// Returns the distance from each position to its `rank`-th nearest other position; to the farthest if there are fewer
// others, and 0 if there is none. Uses a thread for each core. REQUIRES: positions are finite, rank in [1, 32].
std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank);

}  // namespace curv
