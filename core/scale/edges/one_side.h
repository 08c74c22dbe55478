// Curvature of a point beside a sharp edge, from the neighbors on its own side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "Eigen/Core"
#include "core/scale/point_fits/neighbor_normal.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// What is known before neighbors are told apart.
struct SideLimits {
  size_t count;          // of neighbors on the point's side that are wanted
  double normal_noise;   // standard deviation of normals along each tangent
  double height_noise;   // of positions, across the surface
  double allowed_error;  // of the mean curvature that chance may make in a fit of more than degree 1
  uint32_t least_count;  // of neighbors whose heights are fitted
};

// Estimates from the neighbors that a smooth surface through the point explains. They are found from the nearest
// outwards, each ring by what the smaller ones predict: its normals, and by them its heights. Then their normals are
// fitted, and their heights where these may be more exact; the estimate is the one whose error is smaller. Lengths of
// the result are in the unit of the offsets. Nothing, if too few are on the point's side. REQUIRES: `neighbors` are
// sorted by distance.
std::optional<PointFit> EstimateOneSide(std::span<const NeighborNormal> neighbors, const Eigen::Vector3d& normal,
                                        const SideLimits& limits);

}  // namespace curvd
