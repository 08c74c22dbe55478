// The core's own searches without what follows them. One thread, the calling one.
#pragma once

#include "bench/clouds.h"
#include "bench/side_by_side.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"

namespace curvd::bench {

// Builds the index on the calling thread. Ends the program on failure.
SpatialIndex BuildIndex(Cloud cloud);

// The search that estimates with `estimator` run: neighborhoods of one group of points after another, each collected
// into arrays (hexagram: the sum of its normals alone, and of fewer points where K is large). radii[id] gets the
// distance of the last neighbor. On the best instruction set of this machine.
void SearchByGroups(const SpatialIndex& index, std::string_view estimator, uint32_t k, float* radii);

// The same by one descent of the tree for each point: the core's path for uneven surroundings.
void SearchByDescent(const SpatialIndex& index, uint32_t k, float* radii);

}  // namespace curvd::bench
