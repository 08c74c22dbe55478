// Curvature of a point from the largest neighborhood that agrees with all smaller ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "Eigen/Core"
#include "core/estimators/curvature_field.h"
#include "core/scale/normal_fits/neighbor_normal.h"

namespace curvd {

// Lengths are in the unit of the offsets.
struct DetailEstimate {
  PointCurvature point;
  uint32_t neighbor_count;
  double mean_error, k1_error, k2_error;  // standard errors of the curvatures
};

// Fits the normals of more and more neighbors, as the local cubic regression does, and takes intervals of the mean
// curvature by what each fit leaves of the normals. Once an interval has no point in common with all before, detail has
// been smoothed away (Goldenshluger, Nemirovski, *On spatially adaptive estimation of nonparametric regression*, 1997).
// The estimate is that of the last rung but one of those before, whose bias is hardly more than its noise; of the last
// one, where neighbors determine the other far less. `normal` is the point's own, `mean` the mean curvature that it has
// so far; no rung has fewer neighbors than `least_count`. Nothing where the last rung differs from `mean` by no more
// than its noise explains, and where fewer than two rungs determine a fit. REQUIRES: `neighbors` are sorted by
// distance, and no copies of each other. Thread-safe. May throw std::bad_alloc.
std::optional<DetailEstimate> EstimateDetail(std::span<const NeighborNormal> neighbors, const Eigen::Vector3d& normal,
                                             uint32_t least_count, double mean);

}  // namespace curvd
