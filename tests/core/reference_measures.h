// Corrected measures in plain doubles, for the oracles. Written from the paper's definitions and docs/numerics.md;
// shares nothing with core/kernels.
#pragma once

#include <Eigen/Dense>
#include <array>

namespace curvd::testing {

inline Eigen::Vector3d ToVector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

struct ReferenceCorner {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
};

struct ReferenceCurvature {
  bool estimated = false;
  double mean = 0, gaussian = 0, k1 = 0, k2 = 0;
  // Sum of the magnitudes that cancel in `gaussian`: rounding is relative to it.
  double gaussian_magnitude = 0;
  double radius = 0;
  // How near the decisions behind it (neighbors, sectors, triangles) are to a tie that rounding may decide either way,
  // relative.
  double margin = 0;
};

struct ReferenceMeasures {
  double area = 0, mean = 0, gaussian = 0, gaussian_magnitude = 0;
  Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();  // in the tangent axes

  // Adds `weight` times the measures of a triangle, turned so that its area is not negative: Lachaud et al. 2023,
  // Property 1, with 1/4 in the mean measure.
  void AddTriangle(const ReferenceCorner& a, const ReferenceCorner& b, const ReferenceCorner& c,
                   const Eigen::Vector3d axes[2], double weight = 1.0);

  // Sets the curvatures of `out`.
  void ToCurvature(ReferenceCurvature& out) const;
};

// The tangent axes for a unit normal.
void TangentAxes(const Eigen::Vector3d& n, Eigen::Vector3d axes[2]);

}  // namespace curvd::testing
