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

// Columns that summing one sphere uses.
inline constexpr size_t kSphereColumns = SphereSums::kMoments + 5;

}  // namespace curvd
