// Surfaces fitted to one neighborhood in plain doubles with Eigen: the oracle for core/estimators/fits/jet-inl.h,
// core/estimators/fits/algebraic_sphere-inl.h, core/estimators/fits/normal_regression-inl.h and
// core/estimators/fits/linear_regression-inl.h.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "tests/core/test_clouds.h"

namespace curvd::testing {

struct ReferenceNeighborhood {
  std::vector<Eigen::Vector3d> offsets;  // from the query point, rounded to float as the search stores them
  std::vector<Eigen::Vector3d> normals;
  Eigen::Vector3d own_normal;
};

ReferenceNeighborhood NeighborhoodOf(const TestPoints& points, size_t i, const std::vector<int>& ids);

// The shape operator, in some orthonormal basis of the tangent plane, of the jet of that degree over the plane that the
// neighbors lie nearest to; by singular values. Nothing if its least squares problem is ill-conditioned.
std::optional<Eigen::Matrix2d> JetShapeOperator(const ReferenceNeighborhood& neighborhood, int degree);

// The symmetric part of the derivative of the unit gradient of the field of algebraic spheres with weights
// (1 - (d / radius)^2)^2. Differentiates every weighted sum in turn. Nothing if the neighbors fix no sphere.
std::optional<Eigen::Matrix2d> AlgebraicShapeOperator(const ReferenceNeighborhood& neighborhood, double radius,
                                                      bool project);

// The derivative, over the tangent plane at the query point, of the field of unit normals that the polynomials of that
// degree define which fit the neighbors' normals best over the plane normal to `axis`, with weights
// 1 - (d / radius)^2, d being the distance within the plane. By singular values, and by the fundamental forms of a
// surface with the fitted normal. Nothing if the least squares problem is ill-conditioned.
std::optional<Eigen::Matrix2d> NormalRegressionOperator(const ReferenceNeighborhood& neighborhood, double radius,
                                                        const Eigen::Vector3d& axis, int degree);

// The same of the linear field over space that fits the normals best, of which the entries along the point's own normal
// have a penalty that depends on what the best field without one leaves; over the field's root mean square length. By
// singular values of the design matrix, with a row for the penalty. Nothing if there are fewer than 8 neighbors, or if
// they lie on a line.
std::optional<Eigen::Matrix2d> LinearRegressionOperator(const ReferenceNeighborhood& neighborhood);

}  // namespace curvd::testing
