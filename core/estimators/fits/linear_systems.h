// The least squares problems of the linear regression of normals over space, for the points of a group.
#pragma once

#include "core/estimators/fits/group_shapes.h"

namespace curvd {

// Coefficients of one component of the normals; and neighbors more than that from which what is left says something.
inline constexpr double kLinearSize = 4.0, kLeastLinearFreedom = 4.0;
// Added to the variances of the neighbors along all axes, as a part of their sum: planes have none along one.
inline constexpr double kLeastLinearVariance = 1e-9;
// Neighbors that spread less than the root of this in one tangent direction, compared with the other, lie on a line.
inline constexpr double kMinLinearSpread = 1e-6;

// Sums over the neighbors of each point, with offsets q in units of rho and normals n. What points that are not
// estimated have is never used.
struct alignas(64) LinearSystems {
  static constexpr int kProducts = 6;  // xx xy xz yy yz zz

  GroupDoubles count;
  GroupDoubles offset[3];
  GroupDoubles normal[3];
  GroupDoubles offsets[kProducts];  // of the components of q times each other
  GroupDoubles normals[3][3];       // [c][a]: of n's component c times q's component a
};

// What decides whether points have a fit, and on which side of it is out.
struct alignas(64) LinearChecks {
  GroupDoubles spread;  // squared, of the neighbors along the narrower tangent direction over the wider, at most
  GroupDoubles length;  // of the fitted normal at the point, or its root mean square over the neighbors if that is less
  GroupDoubles outward;  // the fitted normal times the point's own
};

}  // namespace curvd
