// How many points lie at one place.
#pragma once

#include <cstddef>

#include "core/index/spatial_index.h"

namespace curvd {

// The mean number of points at the place of one of a group, itself included, as far as they are of this group. Those
// nearly there count, too, if they are too many for chance.
double MeanCopies(const SpatialIndex& index, size_t group);

}  // namespace curvd
