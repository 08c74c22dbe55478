// Normals that are made anew in place of given ones, whose sides they keep.
#pragma once

#include <memory>

#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// A run of one phase, "normals", which fits every point, halo included, and writes its normal, of unit length, in the
// place of half normals: on the side of the index's normal, or, where that is 60 degrees from the new one or more, of
// those of others in the group. The index's normals stay as they are, so that the result depends on no order. Points
// without a fit get the normal that they have, or none. The counts of its scratch are of all points: kOk, or
// kTooFewNeighbors for those that get none anew. REQUIRES: index.has_normals(), and has_half_normals(), of any values;
// it outlives the run.
std::unique_ptr<StrategyRun> StartNormalRefit(const NormalFit& fit, SpatialIndex& index);

}  // namespace curvd
