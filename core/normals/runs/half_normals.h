// Normals of halves of a cloud, which tell what noise does to normals.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// The fewest neighbors of a fit of this method of which a half tells enough.
uint32_t LeastNeighborCountOfHalves(NormalMethod method);

// Whether few points lie at the place of others, whose noise they share, as a sample shows.
bool HasFewCopies(const SpatialIndex& index);

// Whether normals may be made of each half of the neighbors of a fit: a fixed number of them is large enough for
// halves, they are of one sheet, and there are few copies of points.
bool HasHalves(const NormalFit& fit, const SpatialIndex& index);

// A run of two phases, "normals", one for each half of the points: fits each point to those of its neighbors that are
// of its own half, and writes the index's half normals, on the side of its normals. Where a half determines no fit, the
// half normal is the normal itself. The counts of its scratch are of all points: kOk, or kTooFewNeighbors for those of
// which the half determines none. REQUIRES: HasHalves(fit, index); index.has_half_normals(), and its normals are made
// and have their sides; it outlives the run.
std::unique_ptr<StrategyRun> StartHalfNormals(const NormalFit& fit, SpatialIndex& index);

// Whether nearly all of the normals that such a run has made are of halves, by the counts of its scratch.
bool AreHalfNormals(std::span<const uint64_t> status_counts);

}  // namespace curvd
