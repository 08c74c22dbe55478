#include "core/scale/local_weights.h"

#include <algorithm>

namespace curvd {

LocalWeights::LocalWeights(PilotPoints table, const ScaleChoice& choice) : choice_(choice), samples_(table) {}

void LocalWeights::Start(const Box& box) {
  if (!choice_.mean.trends.empty()) samples_.Start(box, ScaleChoice::kNearest);
}

LocalWeights::PointWeights LocalWeights::At(const float* position) {
  if (!choice_.mean.trends.empty()) {
    const std::span<const uint32_t> nearest = samples_.At(position);
    return {WeightsOf(choice_.mean, nearest), WeightsOf(choice_.gaussian, nearest)};
  }
  PointWeights weights{};
  std::copy(choice_.mean.cloud_weights.begin(), choice_.mean.cloud_weights.end(), weights.mean.begin());
  std::copy(choice_.gaussian.cloud_weights.begin(), choice_.gaussian.cloud_weights.end(), weights.gaussian.begin());
  return weights;
}

LocalWeights::Weights LocalWeights::WeightsOf(const ScaleWeights& weights, std::span<const uint32_t> nearest) {
  Weights near{};
  for (size_t c = 0; c < weights.trends.size(); ++c) {
    double sum = 0.0;
    for (const uint32_t i : nearest) sum += weights.local_differences[i][c];
    near[c] = ScaleWeight(weights.trends[c].ErrorAt(sum / static_cast<double>(nearest.size())));
  }
  return near;
}

}  // namespace curvd
