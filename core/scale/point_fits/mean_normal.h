// The normal of a plane over which neighbors are fitted.
#pragma once

#include <algorithm>
#include <span>

#include "Eigen/Core"
#include "core/scale/point_fits/neighbor_normal.h"

namespace curvd {

// The mean of a point's normal and that of its nearest neighbors, of unit length.
inline Eigen::Vector3d MeanNormal(std::span<const NeighborNormal> nearest, const Eigen::Vector3d& normal) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const NeighborNormal& neighbor : nearest) sum += neighbor.normal;
  const Eigen::Vector3d both = normal + sum / std::max(sum.norm(), 1e-3);
  return both.norm() > 0.1 ? Eigen::Vector3d(both.normalized()) : normal;
}

}  // namespace curvd
