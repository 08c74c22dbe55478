#include "core/scale/local_weights.h"

#include <algorithm>

namespace curvd {

LocalWeights::LocalWeights(PilotPoints table, const ScaleChoice& choice) : choice_(choice), samples_(table) {}

void LocalWeights::Start(const Box& box) {
  if (!choice_.weights.mean.trends.empty()) samples_.Start(box, ScaleChoice::kNearest);
}

LocalWeights::PointWeights LocalWeights::At(const float* position) {
  const auto& [mean, traceless, gaussian] = choice_.weights;
  if (mean.trends.empty()) return {WeightsOf(mean), WeightsOf(traceless), WeightsOf(gaussian)};
  const std::span<const uint32_t> nearest = samples_.At(position);
  PointWeights at = {ErrorsOf(mean, nearest), ErrorsOf(traceless, nearest), ErrorsOf(gaussian, nearest)};
  for (size_t c = 0; c < choice_.chosen.size(); ++c) {
    at.traceless[c] = ScaleWeight(traceless.trends.empty() ? at.mean[c] : AddedError(at.traceless[c], at.mean[c]));
    at.mean[c] = ScaleWeight(at.mean[c]);
    at.gaussian[c] = ScaleWeight(at.gaussian[c]);
  }
  return at;
}

LocalWeights::Weights LocalWeights::WeightsOf(const ScaleWeights& of_cloud) {
  Weights weights{};
  std::copy(of_cloud.cloud_weights.begin(), of_cloud.cloud_weights.end(), weights.begin());
  return weights;
}

LocalWeights::Weights LocalWeights::ErrorsOf(const ScaleWeights& weights, std::span<const uint32_t> nearest) {
  Weights errors{};
  for (size_t c = 0; c < weights.trends.size(); ++c) {
    double sum = 0.0;
    for (const uint32_t i : nearest) sum += weights.local_differences[i][c];
    errors[c] = weights.trends[c].ErrorAt(sum / static_cast<double>(nearest.size()));
  }
  return errors;
}

}  // namespace curvd
