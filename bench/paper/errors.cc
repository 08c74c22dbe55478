#include "bench/paper/errors.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double RootMeanSquare(const std::vector<double>& errors) {
  double squares = 0.0;
  for (double error : errors) squares += error * error;
  return std::sqrt(squares / static_cast<double>(errors.size()));
}

QuantityErrors Summarize(const std::vector<double>& errors) {
  if (errors.empty()) return {kNone, kNone, kNone, kNone, kNone};
  double sum = 0.0;
  for (double error : errors) sum += error;
  return {sum / static_cast<double>(errors.size()), RootMeanSquare(errors), Quantile(errors, 0.25), Median(errors),
          Quantile(errors, 0.75)};
}

// Angle between two lines in degrees.
double AngleBetween(const std::array<float, 3>& a, const curv::Vec3& b) {
  const curv::Vec3 v{a[0], a[1], a[2]};
  return std::atan2(curv::Norm(curv::Cross(v, b)), std::abs(curv::Dot(v, b))) * 180.0 / std::numbers::pi;
}

}  // namespace

FieldErrors MeasureErrors(std::span<const PointCurvature> field, std::span<const curv::SurfaceGeometry> truth) {
  std::vector<double> mean, gaussian, k1, k2, direction;
  for (size_t i = 0; i < field.size(); ++i) {
    const PointCurvature& point = field[i];
    if (point.status != PointStatus::kOk) continue;
    mean.push_back(std::abs(point.mean - truth[i].mean));
    gaussian.push_back(std::abs(point.gaussian - truth[i].gaussian));
    k1.push_back(std::abs(point.k1 - truth[i].k1));
    k2.push_back(std::abs(point.k2 - truth[i].k2));
    // Where the principal curvatures are equal, every direction is principal.
    const double largest = std::max(std::abs(truth[i].k1), std::abs(truth[i].k2));
    if (truth[i].k2 - truth[i].k1 > 1e-6 * largest) direction.push_back(AngleBetween(point.d1, truth[i].d1));
  }
  return {.mean = Summarize(mean),
          .gaussian = Summarize(gaussian),
          .k1 = Summarize(k1),
          .k2 = Summarize(k2),
          .direction_median = direction.empty() ? kNone : Median(direction),
          .estimated = mean.size(),
          .failed = field.size() - mean.size()};
}

}  // namespace curvd::bench
