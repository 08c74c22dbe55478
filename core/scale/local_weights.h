// How much each of the chosen estimates counts at a point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/scale/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Weights at points of one group at a time: those of the sampled points that lie nearest to each, and where the choice
// is that of the whole cloud, the same everywhere. The order of groups does not matter. Not thread-safe.
class LocalWeights {
 public:
  using Weights = std::array<double, ScaleChoice::kMostChosen>;
  // Of each quantity.
  struct PointWeights {
    Weights mean, gaussian;
  };

  // `table` and `choice` outlive the object. REQUIRES: choice.chosen is not empty.
  LocalWeights(const PilotTable& table, const ScaleChoice& choice);

  // Looks at the sampled points around a box; then At(position) gives the weights at any position in it, in the order
  // of ScaleChoice::chosen. They have no particular sum.
  void Start(const Box& box);
  PointWeights At(const float* position);

  size_t bytes() const { return (near_.capacity() + squared_.capacity()) * sizeof(Near); }
  static size_t MostBytes(size_t sampled_points) { return 2 * sampled_points * sizeof(Near); }

 private:
  // From the first `count` of squared_.
  Weights NearestOf(const ScaleWeights& weights, size_t count) const;

  struct Near {
    float squared;  // distance
    uint32_t point;
    friend bool operator<(const Near& a, const Near& b) {
      return a.squared != b.squared ? a.squared < b.squared : a.point < b.point;
    }
  };

  const PilotTable& table_;
  const ScaleChoice& choice_;
  std::vector<Near> near_;     // those among which the nearest of any point in the box are
  std::vector<Near> squared_;  // of the point of the moment
};

}  // namespace curvd
