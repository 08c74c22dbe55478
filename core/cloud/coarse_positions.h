// Finds clouds whose coordinates lost in floats what lies between their points.
#pragma once

#include <optional>

#include "core/cloud/cloud.h"

namespace curvd {

// In the unit of the cloud.
struct CoarsePositions {
  double farthest;  // coordinate from zero, on any axis
  double step;      // between neighboring floats there
  double spacing;   // between points
};

// Tells of positions that were given as floats so far from zero that neighboring floats lie an eighth of the distance
// between points apart, or more; else nothing. That distance is judged by the extent of all but the outermost tenth of
// the cloud on each axis, as if the points lay evenly on a surface. Clouds of fewer than 100 points tell nothing, nor
// do doubles and positions on a lattice. Takes no memory. REQUIRES: Finish was called, TakeRecords was not.
std::optional<CoarsePositions> FindCoarsePositions(const Cloud& cloud);

}  // namespace curvd
