// Normals of halves of a cloud, which tell what noise does to normals.
#pragma once

#include <memory>

#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// Whether a fit has neighbors enough to be made of each half of them. Where it has fewer, the errors that neighbors
// share reach no farther than a few points.
bool HasHalves(const NormalFit& fit);

// A run of two phases, "normals", one for each half of the points: fits each point to those of its neighbors that are
// of its own half, and writes the index's half normals, on the side of its normals. Where a half determines no fit, the
// half normal is the normal itself. REQUIRES: HasHalves(fit); index.has_half_normals(), and its normals are made and
// have their sides; it outlives the run.
std::unique_ptr<StrategyRun> StartHalfNormals(const NormalFit& fit, SpatialIndex& index);

}  // namespace curvd
