// The least squares problems of the local regression of normals, for the points of a group.
#pragma once

#include "core/estimators/fits/group_shapes.h"
#include "core/estimators/fits/jet_systems.h"

namespace curvd {

// Degree of the polynomials that are fitted where the neighbors determine them, and how many coefficients they have.
inline constexpr int kRegressionDegree = 3;
inline constexpr int kRegressionSize = JetSize(kRegressionDegree);
inline constexpr int kRegressionMoments = JetSize(2 * kRegressionDegree);

// The least squares problem of each point: weighted sums over its neighbors, with offsets x, y along the tangent axes
// in units of rho and w = 1 - x^2 - y^2. What points that are not estimated have is never used.
struct alignas(64) RegressionSystems {
  GroupDoubles moments[kRegressionMoments];  // sums of w x^a y^b, and
  GroupDoubles normals[3][kRegressionSize];  // of w x^a y^b times each component of the normal, by JetIndex
  GroupDoubles most_degree;                  // that the polynomials may have
  GroupDoubles doubtful;                     // not 0: the neighbors may lie near a curve
  GroupDoubles degree;                       // of the polynomials; 0 where the neighbors determine none
  GroupDoubles outward;                      // of the fitted normal at the point, along the axis of the frame
};

}  // namespace curvd
