#include "core/scale/nearest_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/order_statistic.h"

namespace curvd {
NearestSamples::NearestSamples(PilotPoints table) {
  positions_.Reserve(table.size());
  for (const PilotPoint& point : table) positions_.Add(point.position);
  near_.Reserve(table.size());
  near_places_.reserve(table.size());
  squared_.reserve(table.size());
  ordered_.reserve(table.size());
  scratch_.reserve(table.size());
  places_.reserve(table.size());
}

void NearestSamples::Start(const Box& box, size_t count) {
  count_ = std::min(count, positions_.size());
  near_.Clear();
  near_places_.clear();
  float center[3];
  float squared_radius = 0.0f;
  for (size_t axis = 0; axis < 3; ++axis) {
    center[axis] = 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
    const float half = box.hi[axis] - center[axis];
    squared_radius += half * half;
  }
  float squared_reach = std::numeric_limits<float>::infinity();
  if (count_ > 0 && positions_.size() > count_) {
    // Whatever is among the nearest of a point in the box lies at most two radii farther from the center than the last
    // of the center's own nearest.
    float farthest = 0.0f;
    for (const uint32_t place : OfAll(center, count_)) farthest = std::max(farthest, squared_[place]);
    constexpr float kRounding = 1.0f + 1e-5f;
    const float reach = (std::sqrt(farthest) + 2.0f * std::sqrt(squared_radius)) * kRounding;
    squared_reach = reach * reach;
  }
  Measure(positions_, center);
  for (uint32_t i = 0; i < positions_.size(); ++i) {
    if (squared_[i] > squared_reach) continue;
    near_.Add(positions_.At(i));
    near_places_.push_back(i);
  }
}

std::span<const uint32_t> NearestSamples::At(const float* position) {
  NearestOf(near_, position, count_);
  for (uint32_t& place : places_) place = near_places_[place];
  return places_;
}

std::span<const uint32_t> NearestSamples::OfAll(const float* position, size_t count) {
  return NearestOf(positions_, position, count);
}

void NearestSamples::Measure(const Positions& samples, const float* position) {
  squared_.resize(samples.size());
  const auto& [x, y, z] = samples.coordinates;
  for (size_t i = 0; i < samples.size(); ++i) {
    const float dx = x[i] - position[0], dy = y[i] - position[1], dz = z[i] - position[2];
    squared_[i] = dx * dx + dy * dy + dz * dz;
  }
}

std::span<const uint32_t> NearestSamples::NearestOf(const Positions& samples, const float* position, size_t count) {
  Measure(samples, position);
  count = std::min(count, samples.size());
  places_.resize(samples.size());
  if (count == samples.size()) {
    std::iota(places_.begin(), places_.end(), 0u);
    return places_;
  }
  if (count == 0) return {};
  ordered_.assign(squared_.begin(), squared_.end());
  scratch_.resize(samples.size());
  const float last = OrderStatistic(std::span(ordered_), std::span(scratch_), count - 1);
  size_t ties_left = count;
  for (const float squared : squared_) ties_left -= squared < last ? 1 : 0;
  // Where a place belongs it is kept; elsewhere the next one overwrites it.
  size_t kept = 0;
  for (uint32_t i = 0; i < samples.size() && kept < count; ++i) {
    const size_t is_nearer = squared_[i] < last ? 1 : 0, is_tied = squared_[i] == last && ties_left > 0 ? 1 : 0;
    places_[kept] = i;
    kept += is_nearer + is_tied;
    ties_left -= is_tied;
  }
  places_.resize(count);
  return places_;
}

}  // namespace curvd
