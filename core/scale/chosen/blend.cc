#include "core/scale/chosen/blend.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Geometry"
#include "core/scale/principal_directions.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// Estimates that differ by more than so much of the largest principal curvature contradict each other.
constexpr double kMostSpreadOfCurvature = 0.1;

Vector3d ToVector(const std::array<float, 3>& v) { return Vector3d(v[0], v[1], v[2]); }

}  // namespace

void Blend::Add(const PointCurvature& estimate, const OfQuantities<double>& weights,
                std::optional<double> most_spread) {
  if (estimate.status != PointStatus::kOk) {
    if (weights.mean > most_refused_) {
      most_refused_ = weights.mean;
      refused_ = UndefinedCurvature(estimate.status);
      if (estimate.status != PointStatus::kTooFewNeighbors) refused_.radius = estimate.radius;
    }
    return;
  }
  if (weights.mean == 0.0) return;
  if (most_spread.has_value() && !steady_.has_value()) {
    steady_ = estimate;
    most_spread_ = *most_spread;
  }
  AddToSpread(estimate, weights);
  weights_.mean += weights.mean;
  weights_.traceless += weights.traceless;
  weights_.gaussian += weights.gaussian;
  mean_ += weights.mean * estimate.mean;
  gaussian_ += weights.gaussian * estimate.gaussian;
  radius_ = std::max(radius_, estimate.radius);
  const Vector3d d1 = ToVector(estimate.d1), d2 = ToVector(estimate.d2), normal = d1.cross(d2);
  for (int i = 0, place = 0; i < 3; ++i) {
    normal_[static_cast<size_t>(i)] += weights.mean * normal[i];
    for (int j = i; j < 3; ++j, ++place) {
      tensor_[static_cast<size_t>(place)] +=
          weights.traceless * (double{estimate.k1} * d1[i] * d1[j] + double{estimate.k2} * d2[i] * d2[j]);
    }
  }
}

void Blend::AddToSpread(const PointCurvature& estimate, const OfQuantities<double>& weights) {
  const double estimated_half = 0.5 * (double{estimate.k2} - estimate.k1);
  if (weights_.mean == 0.0) {
    first_mean_ = estimate.mean;
    first_half_ = estimated_half;
  }
  const double mean = estimate.mean - first_mean_, half = estimated_half - first_half_;
  const double root = std::sqrt(weights.mean * weights.traceless);
  beyond_.mean += weights.mean * mean;
  beyond_.mean_square += weights.mean * mean * mean;
  beyond_.half += weights.traceless * half;
  beyond_.half_square += weights.traceless * half * half;
  beyond_.root_weight += root;
  beyond_.root_mean += root * mean;
  beyond_.root_half += root * half;
  beyond_.root_product += root * mean * half;
}

Blend::Spread Blend::spread() const {
  if (!(weights_.mean > 0.0) || !(weights_.traceless > 0.0)) return {0.0, 0.0, 0.0};
  const double mean = beyond_.mean / weights_.mean, half = beyond_.half / weights_.traceless;
  const double mean_variance = beyond_.mean_square / weights_.mean - mean * mean;
  const double half_variance = beyond_.half_square / weights_.traceless - half * half;
  // Where both have the same weights, this is the covariance of H and of half of k2 - k1.
  const double covariance =
      (beyond_.root_product - mean * beyond_.root_half - half * beyond_.root_mean + mean * half * beyond_.root_weight) /
      std::sqrt(weights_.mean * weights_.traceless);
  const auto deviation = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };
  return {deviation(mean_variance), deviation(mean_variance + half_variance - 2.0 * covariance),
          deviation(mean_variance + half_variance + 2.0 * covariance)};
}

bool Blend::IsContradictory() const {
  if (!steady_.has_value()) return false;
  const double largest = std::max(std::abs(steady_->k1), std::abs(steady_->k2));
  return spread().mean > std::max(kMostSpreadOfCurvature * largest, most_spread_);
}

PointCurvature Blend::Finish() const {
  if (!(weights_.mean > 0.0)) return refused_;
  if (IsContradictory()) return *steady_;
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
  tensor /= weights_.traceless;
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const double a = 0.5 * (u.dot(tensor * u) - v.dot(tensor * v)), b = u.dot(tensor * v), r = std::hypot(a, b);
  const PrincipalDirections directions = DirectionsOf(a, b, u, v, normal);
  const double mean = mean_ / weights_.mean;
  const PointCurvature point = {static_cast<float>(mean),
                                static_cast<float>(gaussian_ / weights_.gaussian),
                                static_cast<float>(mean - r),
                                static_cast<float>(mean + r),
                                directions.d1,
                                directions.d2,
                                radius_,
                                PointStatus::kOk};
  const bool is_finite = std::isfinite(point.k1) && std::isfinite(point.k2) && std::isfinite(point.gaussian);
  return is_finite ? point : undefined(PointStatus::kDegenerateArea);
}

}  // namespace curvd
