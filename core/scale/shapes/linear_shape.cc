#include "core/scale/shapes/linear_shape.h"

#include <algorithm>
#include <cmath>

#include "Eigen/LU"
#include "core/estimators/fits/linear_systems.h"
#include "core/scale/pilot/pilot_systems.h"
#include "core/scale/shapes/field_limits.h"

namespace curvd {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Means of offsets and normals, the covariance of offsets, and that of normals with offsets.
struct Moments {
  Vector3d offset, normal;
  Matrix3d offsets, normals;

  explicit Moments(const PilotSums& sums) {
    const double* const plain = sums.moments();
    const double* const heights = sums.heights();
    constexpr int kX = IndexOf(1, 0), kY = IndexOf(0, 1);
    offset << plain[kX], plain[kY], heights[0];
    offsets << plain[IndexOf(2, 0)], plain[IndexOf(1, 1)], heights[kX], plain[IndexOf(1, 1)], plain[IndexOf(0, 2)],
        heights[kY], heights[kX], heights[kY], sums.height_squares();
    for (int axis = 0; axis < 3; ++axis) {
      const auto component = static_cast<size_t>(axis);
      const double* const of_normals = sums.normals(component);
      normal[axis] = of_normals[0];
      normals.row(axis) << of_normals[kX], of_normals[kY], sums.normal_heights(component);
    }
    const double per_count = 1.0 / sums.count();
    offset *= per_count;
    normal *= per_count;
    offsets = (per_count * offsets - offset * offset.transpose()).eval();
    normals = (per_count * normals - normal * offset.transpose()).eval();
    offsets.diagonal().array() += kLeastLinearVariance * offsets.trace();
  }

  // The field's derivative, with a ridge along z.
  Matrix3d Derivative(double ridge) const {
    Matrix3d ridged = offsets;
    ridged(2, 2) += ridge;
    return normals * ridged.inverse();
  }
  // The mean square of the normals that a field with this derivative has at the neighbors.
  double Explained(const Matrix3d& derivative) const {
    return normal.squaredNorm() + derivative.cwiseProduct(normals).sum();
  }
};

double RidgeOf(const Moments& moments, double distinct) {
  const double trace = moments.offsets.trace(), freedom = distinct - kLinearSize;
  const double left = 0.5 * std::max(1.0 - moments.Explained(moments.Derivative(0.0)), 0.0);
  const double variance = 0.5 * (trace - moments.offsets(2, 2));
  const double squared_bend = 0.5 * moments.normals.topLeftCorner<2, 2>().squaredNorm() / (variance * variance);
  const double ridge = left / (freedom * squared_bend);
  return ridge < trace ? ridge : trace;
}

}  // namespace

std::optional<TangentShape> LinearShapeOf(const PilotSums& sums, double distinct) {
  if (distinct < kLinearSize + kLeastLinearFreedom) return std::nullopt;
  const Moments moments(sums);
  const auto plane = moments.offsets.topLeftCorner<2, 2>();
  if (!(plane.determinant() > kMinLinearSpread * plane.trace() * plane.trace())) return std::nullopt;
  if (!(plane.trace() > kMinLinearSpread * moments.offsets.trace())) return std::nullopt;
  const Matrix3d derivative = moments.Derivative(RidgeOf(moments, distinct));
  const double length = std::sqrt(moments.Explained(derivative));
  const Vector3d at_point = moments.normal - derivative * moments.offset, n = at_point.normalized();
  if (!(std::min(length, at_point.norm()) >= kLeastLengthOfMeanNormal && n.z() > kLeastCosineToFrame))
    return std::nullopt;
  const Vector3d tangent_x(1.0, 0.0, -n.x() / n.z()), tangent_y(0.0, 1.0, -n.y() / n.z());
  return ShapeOf(tangent_x, tangent_y, derivative * tangent_x / length, derivative * tangent_y / length);
}

}  // namespace curvd
