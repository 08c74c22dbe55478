#include "core/scale/errors/attenuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/scale/local_weights.h"

namespace curvd {
namespace {

// What an estimate lost is seen beside neighborhoods of a quarter of its points: so many rungs below. Where these have
// no halves, the next larger ones are taken, but they must be smaller by so many rungs.
constexpr size_t kRungsBelow = 4, kLeastRungsBelow = 2;
// Candidates with halves must have this share of the weights at a sample.
constexpr double kLeastShareWithHalves = 0.5;
// Fewer samples tell no slope, and a slope counts that is so many times its own standard error.
constexpr size_t kLeastWithHalves = 32;
constexpr double kSlopeSignificance = 2.0;

// Of one sample, by each half of its neighbors alone.
struct Halves {
  std::array<ShapeParts, 2> value;  // the averaged estimate
  std::array<ShapeParts, 2> lost;   // what that is expected to have lost, as smaller neighborhoods show it
};

std::optional<ScaleCandidate> SmallerOf(const PilotPoint& point, const ScaleCandidate& one) {
  for (size_t below = std::min(kRungsBelow, one.rung); below >= kLeastRungsBelow; --below) {
    const ScaleCandidate smaller{one.method, one.rung - below};
    if (HasHalves(point, smaller)) return smaller;
  }
  return std::nullopt;
}

std::optional<Halves> HalvesOf(const PilotPoint& point, const ScaleChoice& choice, LocalWeights& local_weights) {
  local_weights.Start({point.position, point.position});
  const LocalWeights::PointWeights weights = local_weights.At(point.position.data());
  ShapeSum all;
  std::array<ShapeSum, 2> values, losses;
  for (size_t c = 0; c < choice.chosen.size(); ++c) {
    const ScaleCandidate& one = choice.chosen[c];
    const ShapeWeight weight{weights.mean[c], weights.traceless[c]};
    const TangentShape shape = EstimateAt(point, one, PilotPoint::kAll);
    if (IsFinite(shape)) all.Add(shape, weight);
    const std::optional<ScaleCandidate> smaller = SmallerOf(point, one);
    if (!smaller.has_value() || !HasHalves(point, one)) continue;
    // Smoothing takes away what grows at least with the number of neighbors: the smaller ones have lost some as well.
    const double per_difference = 1.0 / (1.0 - static_cast<double>(smaller->count()) / one.count());
    for (size_t half = 0; half < 2; ++half) {
      const PilotPoint::Part part = half == 0 ? PilotPoint::kEven : PilotPoint::kOdd;
      const TangentShape value = EstimateAt(point, one, part);
      values[half].Add(value, weight);
      losses[half].Add(ShapeWeight{per_difference, per_difference} * (EstimateAt(point, *smaller, part) - value),
                       weight);
    }
  }
  if (!values[0].weight.IsPositive() || values[0].weight.mean < kLeastShareWithHalves * all.weight.mean)
    return std::nullopt;
  const PrincipalAxes axes(all.Mean());
  Halves halves;
  for (size_t half = 0; half < 2; ++half) {
    halves.value[half] = axes.PartsOf(values[half].Mean());
    halves.lost[half] = axes.PartsOf(losses[half].Mean());
  }
  return halves;
}

// The slope of what one half has lost over its values, by the values of the other half as instruments: noise, which is
// independent in the halves, would make or hide a slope over the values that it is in itself.
Attenuation::OfPart AttenuationOf(const std::vector<Halves>& samples, size_t part) {
  double mean = 0.0, mean_lost = 0.0;
  for (const Halves& s : samples) {
    mean += 0.5 * (s.value[0][part] + s.value[1][part]);
    mean_lost += 0.5 * (s.lost[0][part] + s.lost[1][part]);
  }
  mean /= static_cast<double>(samples.size());
  mean_lost /= static_cast<double>(samples.size());
  double squares = 0.0, products = 0.0;
  for (const Halves& s : samples) {
    for (size_t half = 0; half < 2; ++half) {
      const double instrument = s.value[1 - half][part] - mean;
      squares += instrument * (s.value[half][part] - mean);
      products += instrument * (s.lost[half][part] - mean_lost);
    }
  }
  if (!(squares > 0.0)) return {};
  const double slope = products / squares;
  double variance = 0.0;
  for (const Halves& s : samples) {
    double left = 0.0;
    for (size_t half = 0; half < 2; ++half) {
      left +=
          (s.value[1 - half][part] - mean) * (s.lost[half][part] - mean_lost - slope * (s.value[half][part] - mean));
    }
    variance += left * left;
  }
  const double standard_error = std::sqrt(variance) / squares;
  if (!(slope > kSlopeSignificance * standard_error)) return {};
  return {std::min(slope, 1.0), mean};
}

}  // namespace

Attenuation FindAttenuation(PilotPoints table, const ScaleChoice& choice) {
  LocalWeights local_weights(table, choice);
  std::vector<Halves> samples;
  for (const PilotPoint& point : table) {
    if (const std::optional<Halves> halves = HalvesOf(point, choice, local_weights)) samples.push_back(*halves);
  }
  Attenuation attenuation;
  if (samples.size() < kLeastWithHalves) return attenuation;
  for (size_t part = 0; part < attenuation.of.size(); ++part) attenuation.of[part] = AttenuationOf(samples, part);
  return attenuation;
}

}  // namespace curvd
