// Curvature of a point from the normals of its neighbors.
#pragma once

#include <optional>
#include <span>

#include "core/scale/point_fits/neighbor_normal.h"
#include "core/scale/point_fits/normal_polynomials.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// Fits a polynomial to the normals as the local cubic regression does, in the highest degree, 3 or 2, in which noise
// makes no larger error of the mean curvature than is allowed, or otherwise in degree 1. The errors are those by noise,
// and what a cubic fit of the nearest seven in ten finds otherwise. Nothing where neighbors are too few. REQUIRES:
// `neighbors` are sorted by distance; `radius`, the largest of these, is above 0.
std::optional<PointFit> EstimateByNormals(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors,
                                          double radius, double allowed_error);

// The same, and by how much the cubic fit of the nearest neighbors differs from it in H, in standard deviations of what
// noise makes of that difference; 0 where it is not known.
struct NormalFitWithBias {
  PointFit fit;
  double bias_over_noise;
};
std::optional<NormalFitWithBias> EstimateWithBias(const NormalFrame& frame,
                                                  std::span<const NeighborNormal* const> neighbors, double radius,
                                                  double allowed_error);

}  // namespace curvd
