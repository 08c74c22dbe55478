// Samples of the points of an index, and what they show of all.
#pragma once

#include <cstddef>
#include <vector>

#include "core/index/spatial_index.h"

namespace curvd {

// At most `most` groups at even distances in the tree order: a sample of the cloud.
std::vector<size_t> SampleGroups(const SpatialIndex& index, size_t most);

// The distance between neighboring values that coordinates take, in the index's unit, as a sample of the points shows
// it: of positions that were rounded to a lattice, such as centimeters, or single precision far away from the origin.
// That of the finest axis, so that heights over a grid have none. 0 where they take any value.
double LatticeStep(const SpatialIndex& index);

}  // namespace curvd
