#include "core/scale/nearest_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace curvd {
namespace {

float SquaredDistance(const std::array<float, 3>& a, const float* b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

NearestSamples::NearestSamples(PilotPoints table) {
  positions_.reserve(table.size());
  for (const PilotPoint& point : table) positions_.push_back(point.position);
  near_.reserve(table.size());
  nearest_.reserve(table.size());
  places_.reserve(table.size());
}

void NearestSamples::Start(const Box& box, size_t count) {
  count_ = std::min(count, positions_.size());
  near_.clear();
  float center[3];
  float squared_radius = 0.0f;
  for (size_t axis = 0; axis < 3; ++axis) {
    center[axis] = 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
    const float half = box.hi[axis] - center[axis];
    squared_radius += half * half;
  }
  for (uint32_t i = 0; i < positions_.size(); ++i) near_.push_back({SquaredDistance(positions_[i], center), i});
  if (count_ == 0 || near_.size() <= count_) return;
  // Whatever is among the nearest of a point in the box lies at most two radii farther from the center than the last of
  // the center's own nearest.
  const auto last = near_.begin() + static_cast<std::ptrdiff_t>(count_ - 1);
  std::nth_element(near_.begin(), last, near_.end());
  constexpr float kRounding = 1.0f + 1e-5f;
  const float reach = (std::sqrt(last->squared) + 2.0f * std::sqrt(squared_radius)) * kRounding;
  std::erase_if(near_, [squared_reach = reach * reach](const Near& near) { return near.squared > squared_reach; });
}

std::span<const uint32_t> NearestSamples::At(const float* position) {
  nearest_.clear();
  for (const Near& near : near_) nearest_.push_back({SquaredDistance(positions_[near.place], position), near.place});
  if (count_ < nearest_.size()) {
    std::nth_element(nearest_.begin(), nearest_.begin() + static_cast<std::ptrdiff_t>(count_), nearest_.end());
    nearest_.resize(count_);
  }
  places_.clear();
  for (const Near& near : nearest_) places_.push_back(near.place);
  std::sort(places_.begin(), places_.end());
  return places_;
}

}  // namespace curvd
