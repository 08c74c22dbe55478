#include "core/scale/detail/interval_climb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/point_fits/field_curvature.h"
#include "core/scale/point_fits/mean_normal.h"
#include "core/scale/point_fits/normal_polynomials.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// Fits of fewer neighbors than three for each coefficient say too little of the noise.
constexpr uint32_t kFewest = 32;
// Half the width of an interval, in standard errors. Of few neighbors these are uncertain themselves.
constexpr double kHalfWidth = 1.6, kMoreByFreedom = 4.0;
// What a fit leaves is noise and detail. The least of all rungs counts as noise, each with so many of its own standard
// deviations added, since the least of many is low by chance.
constexpr double kNoiseDeviations = 2.0;
// Where the normal that a fit has at the point is shorter, it is that of a tip or of an edge, which no polynomial
// follows.
constexpr double kLeastLength = 0.8;
// The variance of slopes, times the number of neighbors and the square of their radius: 150 to 370 where neighbors lie
// evenly. Beyond a border, or between few lines of a scan, a cubic is free to bend as the noise has it.
constexpr double kMostFreedomOfSlopes = 600.0;
// A step back loses no more than this factor of its standard error: the root of 2 where neighbors lie evenly.
constexpr double kMostFall = 2.0;
// By so many standard errors the estimate must differ from what is known to take its place.
constexpr double kLeastDifference = 4.0;

// Of one rung.
struct Step {
  PointCurvature point;
  uint32_t count;
  double error;    // standard error of the mean curvature
  double caution;  // by how much larger it may be, as far as so few neighbors tell
  PolynomialFit<3> fit;
};

// Adds neighbors from the nearest on, and fits all that it has.
class Climb {
 public:
  // `radius` is that of all neighbors that there will be.
  Climb(const NormalFrame& frame, double radius) : frame_(frame), unit_(radius) {}

  void Add(std::span<const NeighborNormal> neighbors) {
    for (const NeighborNormal& neighbor : neighbors) {
      const double x = frame_.u.dot(neighbor.offset) / unit_, y = frame_.v.dot(neighbor.offset) / unit_;
      even_.Add(x, y, neighbor.normal, 1.0);
      squared_.Add(x, y, neighbor.normal, x * x + y * y);
    }
    count_ += neighbors.size();
  }

  // Of the neighbors so far, the farthest of which has this distance.
  std::optional<Step> Fit(double radius) {
    const double freedom = static_cast<double>(count_) - PolynomialEquations<3>::kSize;
    if (!(freedom > 0.0) || !(radius > 0.0)) return std::nullopt;
    // Weights 1 - r^2 / radius^2.
    PolynomialEquations<3> equations = even_;
    equations.AddTimes(-(unit_ / radius) * (unit_ / radius), squared_);
    const auto fit = equations.Solve();
    if (!fit.has_value() || !(fit->coefficients.row(0).norm() > kLeastLength)) return std::nullopt;
    const double spread = fit->Variance(1) + fit->Variance(2);  // of the slopes, in units of the variance of normals
    const double reach = radius / unit_;
    if (!(spread * static_cast<double>(count_) * reach * reach < kMostFreedomOfSlopes)) return std::nullopt;
    const double variance = 0.5 * fit->squares / equations.weights() * static_cast<double>(count_) / freedom;
    noise_ = std::min(noise_, variance * (1.0 + kNoiseDeviations / std::sqrt(2.0 * freedom)));
    const double error = 0.5 * std::sqrt(std::min(noise_, variance) * spread) / unit_;
    const auto point = CurvatureOfField(frame_, fit->coefficients.topRows<3>(), unit_, radius);
    if (!point.has_value() || !std::isfinite(error)) return std::nullopt;
    return Step{*point, static_cast<uint32_t>(count_), error, 1.0 + kMoreByFreedom / freedom, *fit};
  }

  // The standard error of a step's mean curvature by what each of its neighbors adds to it: that leaves noise free to
  // change from place to place (White, *A heteroskedasticity-consistent covariance matrix estimator*, 1980).
  double ErrorByResiduals(const Step& step, std::span<const NeighborNormal> neighbors) const {
    using Column = Eigen::Matrix<double, PolynomialEquations<3>::kSize, 1>;
    const Column of_x = step.fit.Weights(1), of_y = step.fit.Weights(2);
    const double most = step.point.radius / unit_;
    double sum = 0.0;
    for (const NeighborNormal& neighbor : neighbors) {
      const double x = frame_.u.dot(neighbor.offset) / unit_, y = frame_.v.dot(neighbor.offset) / unit_;
      const Column terms = MonomialsAt<3>(x, y);
      const double weight = std::max(1.0 - (x * x + y * y) / (most * most), 0.0);
      const Vector3d residual = neighbor.normal - step.fit.coefficients.transpose() * terms;
      const double along_x = of_x.dot(terms), along_y = of_y.dot(terms);
      sum += weight * weight * residual.squaredNorm() * (along_x * along_x + along_y * along_y);
    }
    const double count = static_cast<double>(step.count);
    return 0.5 * std::sqrt(0.5 * sum * count / (count - PolynomialEquations<3>::kSize)) / unit_;
  }

 private:
  const NormalFrame& frame_;
  const double unit_;
  PolynomialEquations<3> even_, squared_;  // with weights 1, and r^2 / unit^2
  size_t count_ = 0;
  double noise_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::optional<PointFit> EstimateDetail(std::span<const NeighborNormal> neighbors, const Vector3d& normal,
                                       uint32_t least_count, std::optional<double> mean) {
  if (neighbors.size() < kFewest) return std::nullopt;
  const NormalFrame frame(MeanNormal(neighbors.first(kFewest / 2), normal));
  Climb climb(frame, neighbors.back().offset.norm());
  std::vector<Step> steps;
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  size_t next = 0;
  for (const uint32_t count : kScaleRungs) {
    if (count < std::max(kFewest, least_count)) continue;
    if (count > neighbors.size()) break;
    climb.Add(neighbors.subspan(next, count - next));
    next = count;
    const auto step = climb.Fit(neighbors[count - 1].offset.norm());
    if (!step.has_value()) continue;
    const double half = kHalfWidth * step->error * step->caution;
    low = std::max(low, step->point.mean - half);
    high = std::min(high, step->point.mean + half);
    if (low > high) break;
    steps.push_back(*step);
  }
  if (steps.size() < (mean.has_value() ? 2 : 1)) return std::nullopt;
  const Step& last = steps.back();
  // Where noise is larger on one side, the fit is less sure than its mean residual says.
  const double by_residuals = climb.ErrorByResiduals(last, neighbors.first(last.count));
  const double ratio = last.error > 0.0 ? std::max(by_residuals / last.error, 1.0) : 1.0;
  const double least_difference = kLeastDifference * ratio * last.error * last.caution;
  if (mean.has_value() && !(std::abs(last.point.mean - *mean) > least_difference)) return std::nullopt;
  // Neighbors on a few lines determine the smaller fit far less.
  const Step& before = steps[steps.size() < 2 ? 0 : steps.size() - 2];
  const Step& taken = before.error > kMostFall * last.error ? last : before;
  // What the last step changes tells what bias it may have begun to have.
  const auto with_change = [&](double noise, float now, float then) {
    return std::hypot(noise, static_cast<double>(now) - then);
  };
  const double of_mean = ratio * taken.error, of_principal = std::sqrt(2.0) * of_mean;
  return PointFit{taken.point,
                  taken.count,
                  with_change(of_mean, last.point.mean, taken.point.mean),
                  with_change(of_principal, last.point.k1, taken.point.k1),
                  with_change(of_principal, last.point.k2, taken.point.k2),
                  false};
}

}  // namespace curvd
