#include "core/scale/edges/one_side.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/estimators/scale_ladder.h"
#include "core/scale/point_fits/height_fit.h"
#include "core/scale/point_fits/normal_fit.h"
#include "core/scale/point_fits/normal_polynomials.h"

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
// Where so few of the nearest have the normal of the point, its side is bent: by this angle at most within them.
constexpr double kMostBend = 0.5;
constexpr int kBentRounds = 3;
// Where all neighbors on the side have a bias of so many standard deviations of noise, the normals of fewer are fitted,
// if that leaves less than this part of the error. The least of several errors is low by chance, and counts for more.
constexpr double kLeastBias = 3.0, kMuchLess = 0.5, kCautionOfLeast = 1.25;
// A paraboloid over a disc errs by 6.9 times the noise of the heights over the square of the radius, where all of it
// has one sign; half of that leaves room for what is known of the noise.
constexpr double kLeastHeightError = 3.5;

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
      if (first == 0 && unit > 0.0 && picked_.size() < kLeastCount) PickBent(neighbors.first(last), unit);
      first = last;
      last = std::min(neighbors.size(), last + last / 2);
    }
    return picked_;
  }

 private:
  using Trend = std::optional<PolynomialFit<1>>;

  Trend TrendOf(std::span<const NeighborNormal* const> neighbors, double unit) const {
    PolynomialEquations<1> equations;
    for (const NeighborNormal* const neighbor : neighbors) {
      equations.Add(frame_.u.dot(neighbor->offset) / unit, frame_.v.dot(neighbor->offset) / unit, neighbor->normal,
                    1.0);
    }
    return equations.Solve();
  }

  // Once enough are known, their linear trend tells what comes next.
  void PickRing(std::span<const NeighborNormal> ring, double unit) {
    PickRing(ring, unit, picked_.size() >= kLeastCount ? TrendOf(picked_, unit) : std::nullopt);
  }

  // Picks those of the nearest whose normals go with a trend, which begins with whatever bends little enough.
  void PickBent(std::span<const NeighborNormal> nearest, double unit) {
    const std::vector<const NeighborNormal*> flat = std::move(picked_);
    picked_.clear();
    for (const NeighborNormal& neighbor : nearest) {
      const double most = tolerance_ + kMostBend * neighbor.offset.norm() / unit;
      if ((neighbor.normal - frame_.n).squaredNorm() < most * most) picked_.push_back(&neighbor);
    }
    for (int round = 0; round < kBentRounds && picked_.size() >= kLeastCount; ++round) {
      const Trend trend = TrendOf(picked_, unit);
      picked_.clear();
      if (trend.has_value()) PickRing(nearest, unit, trend);
    }
    if (picked_.size() < kLeastCount) picked_ = flat;
  }

  void PickRing(std::span<const NeighborNormal> ring, double unit, const Trend& trend) {
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

// By the normals of all that were picked, or of the nearest of these where all have a bias.
std::optional<PointFit> EstimateBySideNormals(const NormalFrame& frame, std::span<const NeighborNormal* const> picked,
                                              double allowed_error) {
  const auto of = [&](size_t count) {
    return EstimateWithBias(frame, picked.first(count), picked[count - 1]->offset.norm(), allowed_error);
  };
  const std::optional<NormalFitWithBias> all = of(picked.size());
  if (!all.has_value()) return std::nullopt;
  if (!(all->bias_over_noise > kLeastBias)) return all->fit;
  std::optional<PointFit> best;
  for (const uint32_t count : kScaleRungs) {
    if (count >= picked.size()) break;
    const std::optional<NormalFitWithBias> fewer = of(count);
    const double most = best.has_value() ? best->mean_error : kMuchLess * all->fit.mean_error;
    if (fewer.has_value() && fewer->fit.mean_error < most) best = fewer->fit;
  }
  if (!best.has_value()) return all->fit;
  for (double PointFit::*error : {&PointFit::mean_error, &PointFit::k1_error, &PointFit::k2_error}) {
    (*best).*error *= kCautionOfLeast;
  }
  return best;
}

}  // namespace

std::optional<PointFit> EstimateOneSide(std::span<const NeighborNormal> neighbors, const Vector3d& normal,
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
  const auto by_normals = EstimateBySideNormals(frame, picked, limits.allowed_error);
  const double least_by_heights = kLeastHeightError * limits.height_noise / (radius * radius);
  if (by_normals.has_value() && by_normals->mean_error < least_by_heights) return by_normals;
  const auto by_heights = EstimateByHeights(frame, picked, limits.least_count, limits.height_noise);
  if (!by_heights.has_value() || !by_normals.has_value()) return by_heights.has_value() ? by_heights : by_normals;
  return by_heights->mean_error < by_normals->mean_error ? by_heights : by_normals;
}

}  // namespace curvd
