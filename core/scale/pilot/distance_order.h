// Orders the neighbors of a point by their distance.
#pragma once

#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// Sets s.squared to the squared distances of the neighbors, and s.order to the neighbors by distance; equal distances
// go to the lower id. Sums must not depend on the order of the tree.
void OrderByDistance(PilotScratch& s);

}  // namespace curvd
