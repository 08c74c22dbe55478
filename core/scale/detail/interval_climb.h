// Curvature of a point from the largest neighborhood that agrees with all smaller ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "Eigen/Core"
#include "core/estimators/curvature_field.h"
#include "core/scale/normal_fits/neighbor_normal.h"

namespace curvd {

struct DetailEstimate {
  PointCurvature point;
  uint32_t neighbor_count;
  double mean_error, k1_error, k2_error;  // standard errors
};

// Fits the normals of more and more neighbors, as the local cubic regression does, and takes intervals of the mean
// curvature by what each fit leaves of the normals. Once an interval has no point in common with all before, detail has
// been smoothed away (Goldenshluger, Nemirovski, *On spatially adaptive estimation of nonparametric regression*, 1997):
// the estimate is that of the last rung but one of those before, whose bias is hardly more than its noise. Nothing,
// unless the last rung differs from `mean` by more than its noise explains, or where too few neighbors tell. All
// lengths are in the unit of the offsets. REQUIRES: `neighbors` are sorted by distance.
std::optional<DetailEstimate> EstimateDetail(std::span<const NeighborNormal> neighbors, const Eigen::Vector3d& normal,
                                             uint32_t least_count, double mean);

}  // namespace curvd
