#include "core/scale/automatic_options.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace curvd {

AutomaticScale ScaleOf(const EstimatorOptions& options) {
  if (const auto* scale = std::get_if<AutomaticScale>(&options.neighborhood)) return *scale;
  return {};
}

std::optional<uint32_t> FixedCount(const EstimatorOptions& options) {
  if (const auto* count = std::get_if<NeighborCount>(&options.neighborhood)) return count->count;
  const auto* scale = std::get_if<AutomaticScale>(&options.neighborhood);
  if (scale == nullptr) return std::nullopt;
  const uint32_t least = scale->least_count, most = std::min(scale->most_count, options.max_neighbor_count);
  const bool leaves_choice =
      std::any_of(kScaleRungs.begin(), kScaleRungs.end(), [&](uint32_t rung) { return rung >= least && rung <= most; });
  if (leaves_choice) return std::nullopt;
  return std::clamp(kScaleRungs[RungNear(most)], least, most);
}

EstimatorOptions WithinCloud(EstimatorOptions options, size_t point_count) {
  if (auto* scale = std::get_if<AutomaticScale>(&options.neighborhood)) {
    const auto most = static_cast<uint32_t>(std::min<size_t>(scale->most_count, point_count));
    scale->most_count = std::max(scale->least_count, most);
  }
  return options;
}

size_t RungNear(uint32_t count) {
  const auto distance = [count](uint32_t rung) { return std::abs(std::log(static_cast<double>(rung) / count)); };
  const auto nearest = std::min_element(kScaleRungs.begin(), kScaleRungs.end(),
                                        [&](uint32_t a, uint32_t b) { return distance(a) < distance(b); });
  return static_cast<size_t>(nearest - kScaleRungs.begin());
}

bool IsCandidate(const EstimatorOptions& options, size_t method) {
  if (options.estimator == kAutomaticEstimator) return true;
  const ScaleMethod& one = kScaleMethods[method];
  if (options.estimator != one.estimator) return false;
  if (one.is_jet()) return one.degree == options.jet_degree;
  if (one.is_sphere()) return options.project;
  return !one.is_regression() || one.degree == options.regression_degree;
}

EstimatorOptions OptionsOf(const EstimatorOptions& options, size_t method, uint32_t count) {
  EstimatorOptions one = options;
  const ScaleMethod& chosen = kScaleMethods[method];
  one.estimator = chosen.estimator;
  if (chosen.is_jet()) one.jet_degree = chosen.degree;
  if (chosen.is_regression()) one.regression_degree = chosen.degree;
  if (chosen.is_sphere()) one.project = true;
  one.neighborhood = NeighborCount{FixedCount(options).value_or(count)};
  return one;
}

uint32_t MostCount(const EstimatorOptions& options) {
  return std::min(FixedCount(options).value_or(ScaleOf(options).most_count), options.max_neighbor_count);
}

uint32_t MostSampledCount(const EstimatorOptions& options) {
  const size_t rung = std::min(RungNear(MostCount(options)) + 2, kRungCount - 1);
  return kScaleRungs[rung];
}

ScaleBounds BoundsOf(const EstimatorOptions& options, const SpatialIndex& index) {
  ScaleBounds bounds;
  for (size_t m = 0; m < kMethodCount; ++m) bounds.methods[m] = IsCandidate(options, m);
  const AutomaticScale scale = ScaleOf(options);
  bounds.per_cloud = scale.per_cloud;
  if (const auto count = FixedCount(options)) {
    bounds.least_count = bounds.most_count = kScaleRungs[RungNear(*count)];
    return bounds;
  }
  bounds.least_count = scale.least_count;
  bounds.most_count = MostCount(options);
  if (scale.max_radius > 0.0) {
    bounds.most_radius = static_cast<float>(std::ldexp(scale.max_radius, index.scale_exponent()));
  }
  return bounds;
}

bool MindsEdges(const EstimatorOptions& options) {
  return options.estimator == kAutomaticEstimator && std::holds_alternative<AutomaticScale>(options.neighborhood);
}

bool IsPerPoint(const EstimatorOptions& options) { return options.is_automatic() && !ScaleOf(options).per_cloud; }

bool MayHaveOwnFits(const EstimatorOptions& options) { return IsPerPoint(options) && !FixedCount(options).has_value(); }

// What the regression of normals and hexagrams take first derivatives of goes with the count as count^-2, what jets
// take second ones of as count^-3.
double VarianceFactor(const EstimatorOptions& options, const ScaleCandidate& candidate) {
  const double ratio = static_cast<double>(candidate.count()) / FixedCount(options).value_or(candidate.count());
  return kScaleMethods[candidate.method].is_jet() ? ratio * ratio * ratio : ratio * ratio;
}

}  // namespace curvd
