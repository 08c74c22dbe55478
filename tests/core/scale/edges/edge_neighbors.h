// Neighbors of points beside a sharp edge.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/scale/edges/normal_trend.h"

namespace curvd::testing {

// Neighbors of a point that is `distance` from an edge: it lies on a cylinder of this curvature along y, which ends
// there; a plane goes on at a right angle. Sorted by distance.
inline std::vector<NeighborNormal> NeighborsAtEdge(double curvature, double distance, double noise) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1.0);
  std::vector<NeighborNormal> neighbors;
  neighbors.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()});
  const auto add = [&](const Eigen::Vector3d& offset, Eigen::Vector3d direction) {
    if (noise > 0.0) direction += Eigen::Vector3d(normal(random), normal(random), normal(random));
    neighbors.push_back({offset, direction.normalized()});
  };
  for (int i = 0; i < 400; ++i) {
    const double x = coordinate(random), y = coordinate(random), s = std::sin(curvature * y);
    const double bend = curvature > 0.0 ? (std::cos(curvature * y) - 1.0) / curvature : 0.0;
    if (x < distance) {
      add({x, curvature > 0.0 ? s / curvature : y, bend}, {0.0, s, std::cos(curvature * y)});
    } else {
      add({distance, y, bend - (x - distance)}, {1.0, 0.0, 0.0});
    }
  }
  std::sort(neighbors.begin(), neighbors.end(),
            [](const auto& a, const auto& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); });
  return neighbors;
}

}  // namespace curvd::testing
