#include "core/scale/local_weights.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

float SquaredDistanceTo(const std::array<float, 3>& a, const float* b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

LocalWeights::LocalWeights(const PilotTable& table, const ScaleChoice& choice) : table_(table), choice_(choice) {
  near_.reserve(table.size());
  squared_.reserve(table.size());
}

void LocalWeights::Start(const Box& box) {
  near_.clear();
  if (choice_.mean.trends.empty()) return;
  float center[3];
  float squared_radius = 0.0f;
  for (size_t axis = 0; axis < 3; ++axis) {
    center[axis] = 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
    const float half = box.hi[axis] - center[axis];
    squared_radius += half * half;
  }
  for (uint32_t i = 0; i < table_.size(); ++i) near_.push_back({SquaredDistanceTo(table_[i].position, center), i});
  if (near_.size() <= ScaleChoice::kNearest) return;
  // Whatever is among the nearest of a point in the box lies at most two radii farther from the center than the last of
  // the center's own nearest.
  const auto last = near_.begin() + (ScaleChoice::kNearest - 1);
  std::nth_element(near_.begin(), last, near_.end());
  constexpr float kRounding = 1.0f + 1e-5f;
  const float reach = (std::sqrt(last->squared) + 2.0f * std::sqrt(squared_radius)) * kRounding;
  std::erase_if(near_, [squared_reach = reach * reach](const Near& near) { return near.squared > squared_reach; });
}

LocalWeights::PointWeights LocalWeights::At(const float* position) {
  if (choice_.mean.trends.empty()) {
    PointWeights weights{};
    std::copy(choice_.mean.cloud_weights.begin(), choice_.mean.cloud_weights.end(), weights.mean.begin());
    std::copy(choice_.gaussian.cloud_weights.begin(), choice_.gaussian.cloud_weights.end(), weights.gaussian.begin());
    return weights;
  }
  squared_.clear();
  for (const Near& near : near_)
    squared_.push_back({SquaredDistanceTo(table_[near.point].position, position), near.point});
  const size_t count = std::min(ScaleChoice::kNearest, squared_.size());
  if (count < squared_.size()) {
    std::nth_element(squared_.begin(), squared_.begin() + static_cast<std::ptrdiff_t>(count - 1), squared_.end());
  }
  // Sums must not depend on the order in which the points were found.
  std::sort(squared_.begin(), squared_.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Near& a, const Near& b) { return a.point < b.point; });
  return {NearestOf(choice_.mean, count), NearestOf(choice_.gaussian, count)};
}

LocalWeights::Weights LocalWeights::NearestOf(const ScaleWeights& weights, size_t count) const {
  Weights nearest{};
  for (size_t c = 0; c < weights.trends.size(); ++c) {
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) sum += weights.local_differences[squared_[i].point][c];
    nearest[c] = ScaleWeight(weights.trends[c].ErrorAt(sum / static_cast<double>(count)));
  }
  return nearest;
}

}  // namespace curvd
