// How much each of the estimates that are chosen for a cloud counts at a point.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/scale/local_weights.h"
#include "core/scale/of_quantities.h"
#include "core/scale/parts/cloud_choice.h"
#include "core/scale/parts/cloud_parts.h"

namespace curvd {

// Those of the part of the cloud that the point belongs to; the others' are 0. For one group at a time, as
// LocalWeights. Not thread-safe.
class CloudWeights {
 public:
  // In the order of CloudChoice::chosen.
  using Weights = std::array<double, CloudChoice::kMostChosen>;
  using PointWeights = OfQuantities<Weights>;

  // REQUIRES: each part has chosen candidates. `choice` outlives the object.
  explicit CloudWeights(const CloudChoice& choice);

  void Start(const Box& box);
  // What follows REQUIRES: Start was called with a box that holds the position.
  PointWeights At(const float* position) { return At(position, PartAt(position)); }
  // Those that a part would have there.
  PointWeights At(const float* position, size_t part);
  size_t PartAt(const float* position) { return parts_.PartAt(position); }
  // Whether a place of the first part is near the second.
  bool IsNearSecond(const float* position) { return parts_.IsNearSecond(position); }

  size_t bytes() const;
  static size_t MostBytes(size_t sampled_points) {
    return LocalWeights::MostBytes(sampled_points) + PartFinder::MostBytes(sampled_points) +
           CloudChoice::kMostParts * sizeof(LocalWeights);
  }

 private:
  const CloudChoice& choice_;
  PartFinder parts_;
  std::vector<LocalWeights> weights_;  // of each part
};

}  // namespace curvd
