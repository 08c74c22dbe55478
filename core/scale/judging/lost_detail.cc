#include "core/scale/judging/lost_detail.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/quantile.h"
#include "core/scale/pilot/sample_medians.h"

namespace curvd {
namespace {

// The first rung whose jets leave something of the heights.
constexpr size_t kFirstRung = 1;
// Of the sampled points whose neighborhoods reach over no edge, so many must have jets, and so many in all.
constexpr double kLeastShare = 0.95;
constexpr size_t kLeastPoints = 16;
// Steps at single points beyond these quantiles are cut down to them.
constexpr double kLeastQuantile = 0.05, kMostQuantile = 0.95;
// A ball that is hardly larger than the noise leaves its outer parts out, so that what jets leave grows with it.
constexpr double kLeastRadiusOverResidual = 8.0;
// Jets of degree 4 lose waves of this length, over the radius of their neighborhood.
constexpr double kWavelengthPerRadius = 1.05;
// A step begins a loss if it is so many times its standard error, and one that is smaller ends it: on a smooth surface
// steps grow five times from rung to rung.
constexpr double kSignificance = 5.0;
// What is lost counts as far as it is more than so many times its standard error.
constexpr double kMargin = 2.0;
// Jets begin to lose waves so many rungs before they lose most.
constexpr size_t kRungsBeforePeak = 3;
// The median growth must be this share of the mean one.
constexpr double kLeastMedianOverMean = 0.85;
// By the same number of neighbors methods of the second order lose waves as jets of degree 4 do so many rungs on;
// regressions of the normals of degree 3, which count the nearest the most, and jets of degree 6 as those so many rungs
// before.
constexpr size_t kRungsOn = 2, kRungsBefore = 2;

struct Mean {
  double value, standard_error;
};

// Neighborhoods of sampled points overlap: a quarter of the points are independent.
Mean MeanOf(const std::vector<double>& values) {
  const double size = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const double mean = sum / size;
  return {mean, std::sqrt(std::max(squares / size - mean * mean, 0.0) / (size / 4.0))};
}

// By how much the squares of what jets leave grow from a rung to the next, at each point; 0 where it is not known.
// Empty: nobody knows.
std::vector<double> StepsFrom(size_t rung, PilotPoints table, double median_radius) {
  std::vector<double> steps, known, residuals;
  steps.reserve(table.size());
  size_t clear = 0;
  for (const PilotPoint& point : table) {
    clear += point.clear_rungs > rung + 1 ? 1 : 0;
    const double here = point.residual[rung], next = point.residual[rung + 1];
    steps.push_back(next * next - here * here);
    if (!std::isfinite(steps.back())) continue;
    known.push_back(steps.back());
    residuals.push_back(here);
  }
  const double least =
      std::max(kLeastShare * static_cast<double>(clear), static_cast<double>(std::min(table.size(), kLeastPoints)));
  if (known.empty() || static_cast<double>(known.size()) < least) return {};
  if (kLeastRadiusOverResidual * Quantile(residuals, 0.5) > median_radius) return {};
  const double low = Quantile(known, kLeastQuantile), high = Quantile(known, kMostQuantile);
  for (double& step : steps) step = std::isfinite(step) ? std::clamp(step, low, high) : 0.0;
  return steps;
}

using Steps = std::array<std::vector<double>, kRungCount>;

// Whether what jets leave grows by these waves at most points alike: neighborhoods that grow into a noisier part, or
// over a single ridge, do so at a few.
bool IsEverywhere(const Steps& steps, size_t peak, size_t end) {
  std::vector<double> growth(steps[peak].size(), 0.0);
  double sum = 0.0;
  for (size_t rung = std::max(peak, kFirstRung + kRungsBeforePeak) - kRungsBeforePeak; rung < end; ++rung) {
    for (size_t i = 0; i < steps[rung].size(); ++i) {
      growth[i] += steps[rung][i];
      sum += steps[rung][i];
    }
  }
  const double mean = sum / static_cast<double>(growth.size());
  return Quantile(growth, 0.5) >= kLeastMedianOverMean * mean;
}

// The square of H of a wave that jets of this radius lose, over the mean square of its heights.
double SquaredCurvature(double radius) {
  const double wave_number = 2.0 * std::numbers::pi / (kWavelengthPerRadius * radius);
  const double mean_curvature = 0.5 * wave_number * wave_number;
  return mean_curvature * mean_curvature;
}

}  // namespace

LostDetail::LostDetail(PilotPoints table) {
  if (table.empty()) return;
  std::array<double, kRungCount> median_radii;
  for (size_t rung = 0; rung < kRungCount; ++rung) median_radii[rung] = MedianRadius(table, rung);
  Steps steps;
  // Steps before `end` are the loss of waves, of which most are lost at `peak`.
  size_t end = 0, peak = 0, largest = 0;
  double most = 0.0;
  for (size_t rung = kFirstRung; rung + 1 < kRungCount; ++rung) {
    steps[rung] = StepsFrom(rung, table, median_radii[rung]);
    if (steps[rung].empty()) continue;
    const Mean step = MeanOf(steps[rung]);
    if (step.value > kSignificance * step.standard_error && step.value > most) {
      most = step.value;
      largest = rung;
    }
    if (most > 0.0 && step.value + step.standard_error < most) {
      end = rung;
      peak = largest;
    }
  }
  if (end == 0 || !IsEverywhere(steps, peak, end)) return;
  // What grows before the peak is of the same waves, which are lost in part.
  for (size_t first = kFirstRung; first < end; ++first) {
    std::vector<double> lost(table.size(), 0.0);
    for (size_t rung = first; rung < end && !steps[rung].empty(); ++rung) {
      const double per_square = SquaredCurvature(median_radii[std::max(rung, peak)]);
      for (size_t i = 0; i < lost.size(); ++i) lost[i] += per_square * steps[rung][i];
      const Mean mean = MeanOf(lost);
      squared_bias_[rung + 1] = std::max(squared_bias_[rung + 1], mean.value - kMargin * mean.standard_error);
    }
  }
  for (size_t rung = 1; rung < kRungCount; ++rung) {
    squared_bias_[rung] = std::max(squared_bias_[rung], squared_bias_[rung - 1]);
  }
}

double LostDetail::SquaredBias(const ScaleCandidate& candidate) const {
  const ScaleMethod& method = kScaleMethods[candidate.method];
  if (method.is_second_order()) return squared_bias_[std::min(candidate.rung + kRungsOn, kRungCount - 1)];
  if (candidate.method == kQuarticMethod) return squared_bias_[candidate.rung];
  return candidate.rung < kRungsBefore ? 0.0 : squared_bias_[candidate.rung - kRungsBefore];
}

}  // namespace curvd
