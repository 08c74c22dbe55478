// How much each of the chosen estimates counts at a point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/index/spatial_index.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/of_quantities.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Weights at points of one group at a time: those of the sampled points that lie nearest to each, and where the choice
// is that of the whole cloud, the same everywhere. The order of groups does not matter. Not thread-safe.
class LocalWeights {
 public:
  using Weights = std::array<double, ScaleChoice::kMostChosen>;
  using PointWeights = OfQuantities<Weights>;

  // `table` and `choice` outlive the object. REQUIRES: choice.chosen is not empty.
  LocalWeights(PilotPoints table, const ScaleChoice& choice);

  // Looks at the sampled points around a box; then At(position) gives the weights at any position in it, in the order
  // of ScaleChoice::chosen. They have no particular sum.
  void Start(const Box& box);
  PointWeights At(const float* position);

  size_t bytes() const { return samples_.bytes(); }
  static size_t MostBytes(size_t sampled_points) { return NearestSamples::MostBytes(sampled_points); }

 private:
  static Weights WeightsOf(const ScaleWeights& of_cloud);
  // What each is expected to err by.
  static Weights ErrorsOf(const ScaleWeights& weights, std::span<const uint32_t> nearest);

  const ScaleChoice& choice_;
  NearestSamples samples_;
};

}  // namespace curvd
