// Curvature of a point beside a sharp edge, from the neighbors on its own side.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "Eigen/Core"
#include "core/estimators/curvature_field.h"

namespace curvd {

// A neighbor of a point, which is the origin.
struct SideNeighbor {
  Eigen::Vector3d offset;
  Eigen::Vector3d normal;  // of unit length
};

// How normals of neighbors, the point itself among them, change over the tangent plane.
struct NormalTrend {
  // How far they are from a polynomial of degree 2: the standard deviation along each tangent. An edge of an angle of t
  // leaves about 0.18 times 2 sin(t / 2) of exact normals. NaN where they determine none.
  double roughness;
  double slope;  // how fast they turn where they turn fastest, in 1 / the unit of the offsets
};

// In doubles.
NormalTrend TrendOf(std::span<const SideNeighbor> neighbors);

// What is known before neighbors are told apart.
struct SideLimits {
  size_t count;          // of neighbors on the point's side that are wanted
  double normal_noise;   // standard deviation of normals along each tangent
  double height_noise;   // of positions, across the surface
  double allowed_error;  // of the mean curvature that chance may make in a fit of more than degree 1
};

// Estimates from the neighbors that a smooth surface through the point explains. They are found from the nearest
// outwards, each ring by what the smaller ones predict: its normals, and by them its heights. Their normals are then
// fitted as the local cubic regression does, in the highest degree whose standard error is allowed. Lengths of the
// result are in the unit of the offsets. Nothing, if too few are on the point's side. REQUIRES: `neighbors` are sorted
// by distance.
std::optional<PointCurvature> EstimateOneSide(std::span<const SideNeighbor> neighbors, const Eigen::Vector3d& normal,
                                              const SideLimits& limits);

}  // namespace curvd
