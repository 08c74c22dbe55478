// How the normals of neighbors change over the tangent plane.
#pragma once

#include <span>

#include "core/scale/point_fits/neighbor_normal.h"

namespace curvd {

// How normals of neighbors, the point itself among them, change over the tangent plane.
struct NormalTrend {
  // How far they are from a polynomial of degree 2: the standard deviation along each tangent. An edge of an angle of t
  // leaves about 0.18 times 2 sin(t / 2) of exact normals. NaN where they determine none.
  double roughness;
  double slope;  // how fast they turn where they turn fastest, in 1 / the unit of the offsets
};

// In doubles.
NormalTrend TrendOf(std::span<const NeighborNormal> neighbors);

// Whether normals that a polynomial of degree 2 does not explain are those of a narrow bend or of waves, which one of
// degree 4 explains far better; it is of little help at an edge. False where there are 15 neighbors or fewer.
bool AreOfBend(std::span<const NeighborNormal> neighbors);

}  // namespace curvd
