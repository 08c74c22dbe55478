#include "core/scale/edges/one_side.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/scale/normal_fits/field_curvature.h"
#include "core/scale/normal_fits/normal_polynomials.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// A normal belongs to the point's side if it differs from what is expected by less than so many standard deviations of
// noise, or than what an edge of 10 degrees makes.
constexpr double kMostDeviations = 4.0, kLeastTolerance = 0.17;
// Heights of a surface may differ from those which the normals at both ends give by this share of the distance.
constexpr double kHeightSlack = 0.1;
// The nearest neighbors, from which the rest is reached.
constexpr size_t kCore = 16;
// Fewer on the point's side say nothing.
constexpr size_t kLeastCount = 8;

// The mean of the normals near `normal` among the nearest neighbors.
std::optional<Vector3d> NormalOfSide(std::span<const NeighborNormal> neighbors, Vector3d normal, double tolerance) {
  for (int round = 0; round < 3; ++round) {
    Vector3d sum = Vector3d::Zero();
    for (const NeighborNormal& neighbor : neighbors) {
      if ((neighbor.normal - normal).squaredNorm() < tolerance * tolerance) sum += neighbor.normal;
    }
    if (!(sum.norm() > 0.5)) return std::nullopt;
    normal = sum.normalized();
  }
  return normal;
}

// Picks the neighbors on the side of a point.
class SidePicker {
 public:
  SidePicker(const NormalFrame& frame, const SideLimits& limits)
      : frame_(frame),
        limits_(limits),
        tolerance_(std::max(kMostDeviations * limits.normal_noise, kLeastTolerance)),
        heights_(kMostDeviations * limits.height_noise) {}

  const std::vector<const NeighborNormal*>& Pick(std::span<const NeighborNormal> neighbors) {
    for (size_t first = 0, last = std::min(kCore, neighbors.size()); first < last && picked_.size() < limits_.count;) {
      const double unit = neighbors[last - 1].offset.norm();
      if (unit > 0.0) PickRing(neighbors.subspan(first, last - first), unit);
      first = last;
      last = std::min(neighbors.size(), last + last / 2);
    }
    return picked_;
  }

 private:
  void PickRing(std::span<const NeighborNormal> ring, double unit) {
    // Once enough are known, their linear trend tells what comes next.
    std::optional<PolynomialFit<1>> trend;
    if (picked_.size() >= kLeastCount) {
      PolynomialEquations<1> equations;
      for (const NeighborNormal* const picked : picked_) {
        equations.Add(frame_.u.dot(picked->offset) / unit, frame_.v.dot(picked->offset) / unit, picked->normal, 1.0);
      }
      trend = equations.Solve();
    }
    for (const NeighborNormal& neighbor : ring) {
      Vector3d expected = frame_.n;
      if (trend.has_value()) {
        const double x = frame_.u.dot(neighbor.offset) / unit, y = frame_.v.dot(neighbor.offset) / unit;
        expected = (trend->coefficients.transpose() * MonomialsAt<1>(x, y)).normalized();
      }
      const double height = 0.5 * (expected + frame_.n).dot(neighbor.offset);
      if ((neighbor.normal - expected).squaredNorm() < tolerance_ * tolerance_ &&
          std::abs(height) <= heights_ + kHeightSlack * neighbor.offset.norm()) {
        picked_.push_back(&neighbor);
      }
    }
  }

  const NormalFrame& frame_;
  const SideLimits& limits_;
  const double tolerance_, heights_;
  std::vector<const NeighborNormal*> picked_;
};

// What a fit of that degree says, if chance makes no larger error of it.
template <int kDegree>
std::optional<PointCurvature> CurvatureInDegree(const NormalFrame& frame, const PolynomialEquations<3>& equations,
                                                size_t count, double radius, double allowed_error) {
  const double freedom = static_cast<double>(count) - kPolynomialTerms[kDegree];
  if (!(freedom > 0.0)) return std::nullopt;
  const auto fit = equations.SolveDegree<kDegree>();
  if (!fit.has_value()) return std::nullopt;
  const double variance = 0.5 * fit->squares / equations.weights() * static_cast<double>(count) / freedom;
  const double error = 0.5 * std::sqrt(variance * (fit->Variance(1) + fit->Variance(2))) / radius;
  return error <= allowed_error ? CurvatureOfField(frame, fit->coefficients.template topRows<3>(), radius, radius)
                                : std::nullopt;
}

}  // namespace

std::optional<PointCurvature> EstimateOneSide(std::span<const NeighborNormal> neighbors, const Vector3d& normal,
                                              const SideLimits& limits) {
  const double tolerance = std::max(kMostDeviations * limits.normal_noise, kLeastTolerance);
  const auto side = NormalOfSide(neighbors.first(std::min(kCore, neighbors.size())), normal, tolerance);
  if (!side.has_value()) return std::nullopt;
  const NormalFrame frame(*side);
  SidePicker picker(frame, limits);
  const std::vector<const NeighborNormal*>& picked = picker.Pick(neighbors);
  if (picked.size() < kLeastCount) return std::nullopt;
  const double radius = picked.back()->offset.norm();
  if (!(radius > 0.0)) return std::nullopt;
  PolynomialEquations<3> equations;
  for (const NeighborNormal* const neighbor : picked) {
    const double x = frame.u.dot(neighbor->offset) / radius, y = frame.v.dot(neighbor->offset) / radius;
    equations.Add(x, y, neighbor->normal, std::max(1.0 - x * x - y * y, 0.0));
  }
  if (auto point = CurvatureInDegree<3>(frame, equations, picked.size(), radius, limits.allowed_error)) return point;
  if (auto point = CurvatureInDegree<2>(frame, equations, picked.size(), radius, limits.allowed_error)) return point;
  return CurvatureInDegree<1>(frame, equations, picked.size(), radius, std::numeric_limits<double>::infinity());
}

}  // namespace curvd
