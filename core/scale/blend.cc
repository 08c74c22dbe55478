#include "core/scale/blend.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Geometry"

namespace curvd {
namespace {

using Eigen::Vector3d;

Vector3d ToVector(const std::array<float, 3>& v) { return Vector3d(v[0], v[1], v[2]); }

std::array<float, 3> ToFloats(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void Blend::Add(const PointCurvature& estimate, double weight, double gaussian_weight) {
  if (estimate.status != PointStatus::kOk) {
    if (weight > most_refused_) {
      most_refused_ = weight;
      refused_ = UndefinedCurvature(estimate.status);
      if (estimate.status != PointStatus::kTooFewNeighbors) refused_.radius = estimate.radius;
    }
    return;
  }
  if (weight == 0.0 && gaussian_weight == 0.0) return;
  const std::array<double, 3> found = {estimate.mean, estimate.k1, estimate.k2};
  if (weight_ == 0.0) first_ = found;
  for (size_t i = 0; i < found.size(); ++i) {
    const double beyond = found[i] - first_[i];
    beyond_[i] += weight * beyond;
    squares_[i] += weight * beyond * beyond;
  }
  weight_ += weight;
  gaussian_weight_ += gaussian_weight;
  mean_ += weight * estimate.mean;
  gaussian_ += gaussian_weight * estimate.gaussian;
  radius_ = std::max(radius_, estimate.radius);
  const Vector3d d1 = ToVector(estimate.d1), d2 = ToVector(estimate.d2), normal = d1.cross(d2);
  for (int i = 0, place = 0; i < 3; ++i) {
    normal_[static_cast<size_t>(i)] += weight * normal[i];
    for (int j = i; j < 3; ++j, ++place) {
      tensor_[static_cast<size_t>(place)] +=
          weight * (double{estimate.k1} * d1[i] * d1[j] + double{estimate.k2} * d2[i] * d2[j]);
    }
  }
}

Blend::Spread Blend::spread() const {
  if (!(weight_ > 0.0)) return {0.0, 0.0, 0.0};
  const auto deviation = [this](size_t i) {
    const double mean = beyond_[i] / weight_;
    return std::sqrt(std::max(squares_[i] / weight_ - mean * mean, 0.0));
  };
  return {deviation(0), deviation(1), deviation(2)};
}

PointCurvature Blend::Finish() const {
  if (!(weight_ > 0.0)) return refused_;
  const Vector3d normal = Vector3d(normal_.data()).normalized();
  const auto undefined = [this](PointStatus status) {
    PointCurvature point = UndefinedCurvature(status);
    point.radius = radius_;
    return point;
  };
  if (!normal.allFinite() || normal.isZero()) return undefined(PointStatus::kInconsistentNormals);
  Eigen::Matrix3d tensor;
  tensor << tensor_[0], tensor_[1], tensor_[2],  //
      tensor_[1], tensor_[3], tensor_[4],        //
      tensor_[2], tensor_[4], tensor_[5];
  tensor /= weight_;
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const double a = 0.5 * (u.dot(tensor * u) - v.dot(tensor * v)), b = u.dot(tensor * v), r = std::hypot(a, b);
  // The direction of the larger eigenvalue of [[a, b], [b, -a]].
  const double angle = 0.5 * std::atan2(b, a);
  const Vector3d d2 = std::cos(angle) * u + std::sin(angle) * v;
  const double mean = mean_ / weight_;
  const PointCurvature point = {static_cast<float>(mean),
                                static_cast<float>(gaussian_ / gaussian_weight_),
                                static_cast<float>(mean - r),
                                static_cast<float>(mean + r),
                                ToFloats(d2.cross(normal)),
                                ToFloats(d2),
                                radius_,
                                PointStatus::kOk};
  const bool is_finite = std::isfinite(point.k1) && std::isfinite(point.k2) && std::isfinite(point.gaussian);
  return is_finite ? point : undefined(PointStatus::kDegenerateArea);
}

}  // namespace curvd
