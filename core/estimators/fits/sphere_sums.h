// What the algebraic spheres of a group are fitted from.
#pragma once

#include "core/estimators/fits/group_shapes.h"

namespace curvd {

// Weighted sums over the neighbors of each point, for the algebraic sphere and its derivatives.
struct alignas(64) SphereSums {
  static constexpr int kMoments = 9;  // of 1, q, n, q n, q q

  GroupDoubles weighted[kMoments];     // sums of w times each
  GroupDoubles gradient[3][kMoments];  // of the derivatives of w times each
  GroupDoubles influence_hessian[6];   // of the second derivatives of w times d potential / d w: xx xy xz yy yz zz
};

// Neighbors whose weighted variance is below this fraction of rho^2 fix no sphere, and those that spread less than the
// root of this in one tangent direction, compared with the other, no curvature along it.
inline constexpr double kMinSphereVariance = 1e-6;

// Points that lie so far out that the level through them has ten times the surface's radius of curvature are projected
// nowhere.
inline constexpr double kLeastNearness = 0.1;

// Neighbors whose mean normal is shorter are of a surface that bends all the way around, or of both sides of a wall: a
// surface between them is none to project on.
inline constexpr double kLeastSquaredMean = 0.25;

// Columns that summing one sphere uses, and the most neighbors that they hold.
inline constexpr size_t kSphereColumns = SphereSums::kMoments + 5;
inline constexpr size_t kMostInSphereColumns = 512;

}  // namespace curvd
