// Curvature of a point from the largest neighborhood that agrees with all smaller ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "Eigen/Core"
#include "core/scale/point_fits/neighbor_normal.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// Fits the normals of more and more neighbors, as the local cubic regression does, and takes intervals of the mean
// curvature by what each fit leaves of the normals. Once an interval has no point in common with all before, detail has
// been smoothed away (Goldenshluger, Nemirovski, *On spatially adaptive estimation of nonparametric regression*, 1997).
// The estimate is that of the last rung but one of those before, whose bias is hardly more than its noise; of the last
// one, where neighbors determine the other far less. `normal` is the point's own, `mean` the mean curvature that it has
// so far, if it has one; no rung has fewer neighbors than `least_count`. Nothing where the last rung differs from
// `mean` by no more than its noise explains, and where fewer than two rungs determine a fit; one will do without
// `mean`. REQUIRES: `neighbors` are sorted by distance, and no copies of each other. Lengths are in the unit of the
// offsets. Thread-safe. May throw std::bad_alloc.
std::optional<PointFit> EstimateDetail(std::span<const NeighborNormal> neighbors, const Eigen::Vector3d& normal,
                                       uint32_t least_count, std::optional<double> mean);

}  // namespace curvd
