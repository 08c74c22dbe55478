// The sampled points that lie nearest to a point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Finds them for the points of one box at a time, or for any. The order of boxes does not matter. Not thread-safe.
class NearestSamples {
 public:
  explicit NearestSamples(PilotPoints table);

  // Looks at the sampled points around a box, so that At finds the nearest ones of any position in it.
  void Start(const Box& box, size_t count);
  // The `count` samples that lie nearest to `position`, or all if those are fewer, as places in the table in ascending
  // order: sums over them must not depend on the order in which they were found. Equal distances go to the lower place.
  // Valid until the next call. REQUIRES: Start was called with a box that holds the position.
  std::span<const uint32_t> At(const float* position);
  // The same of any position and of any number, without a box.
  std::span<const uint32_t> OfAll(const float* position, size_t count);

  size_t bytes() const {
    return positions_.bytes() + near_.bytes() + (near_places_.capacity() + places_.capacity()) * sizeof(uint32_t) +
           (squared_.capacity() + ordered_.capacity() + scratch_.capacity()) * sizeof(float);
  }
  static size_t MostBytes(size_t samples) {
    return samples * (2 * sizeof(PilotPoint::position) + 2 * sizeof(uint32_t) + 3 * sizeof(float));
  }

 private:
  // By coordinate, for loops that compilers make vector code of; those of the table lie kilobytes apart.
  struct Positions {
    std::array<std::vector<float>, 3> coordinates;

    size_t size() const { return coordinates[0].size(); }
    size_t bytes() const { return 3 * coordinates[0].capacity() * sizeof(float); }
    void Reserve(size_t count) {
      for (std::vector<float>& of_axis : coordinates) of_axis.reserve(count);
    }
    void Clear() {
      for (std::vector<float>& of_axis : coordinates) of_axis.clear();
    }
    void Add(const std::array<float, 3>& position) {
      for (size_t axis = 0; axis < 3; ++axis) coordinates[axis].push_back(position[axis]);
    }
    std::array<float, 3> At(size_t i) const { return {coordinates[0][i], coordinates[1][i], coordinates[2][i]}; }
  };

  // Writes how far some samples are from a position, squared, to squared_.
  void Measure(const Positions& samples, const float* position);
  // Of some samples, the `count` nearest ones, in places_.
  std::span<const uint32_t> NearestOf(const Positions& samples, const float* position, size_t count);

  Positions positions_;  // of the samples
  size_t count_ = 0;
  // Those among which the nearest of any point in the box are, in the order of their places in the table.
  Positions near_;
  std::vector<uint32_t> near_places_;
  std::vector<float> squared_, ordered_,
      scratch_;                   // distances of the samples of the moment, and what puts them in order
  std::vector<uint32_t> places_;  // of those that are nearest
};

}  // namespace curvd
