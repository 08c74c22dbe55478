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

// Finds them for the points of one box at a time. The order of boxes does not matter. Not thread-safe.
class NearestSamples {
 public:
  explicit NearestSamples(PilotPoints table);

  // Looks at the sampled points around a box, so that At finds the nearest ones of any position in it.
  void Start(const Box& box, size_t count);
  // The `count` samples that lie nearest to `position`, or all if those are fewer, as places in the table in ascending
  // order: sums over them must not depend on the order in which they were found. Equal distances go to the lower place.
  // Valid until the next call. REQUIRES: Start was called with a box that holds the position.
  std::span<const uint32_t> At(const float* position);

  size_t bytes() const {
    return positions_.capacity() * sizeof(Position) + (near_.capacity() + nearest_.capacity()) * sizeof(Near) +
           places_.capacity() * sizeof(uint32_t);
  }
  static size_t MostBytes(size_t samples) { return samples * (sizeof(Position) + 2 * sizeof(Near) + sizeof(uint32_t)); }

 private:
  using Position = std::array<float, 3>;
  struct Near {
    float squared;  // distance
    uint32_t place;
    friend bool operator<(const Near& a, const Near& b) {
      return a.squared != b.squared ? a.squared < b.squared : a.place < b.place;
    }
  };

  std::vector<Position> positions_;  // of the samples: those of the table lie kilobytes apart
  size_t count_ = 0;
  std::vector<Near> near_;        // those among which the nearest of any point in the box are
  std::vector<Near> nearest_;     // of the point of the moment
  std::vector<uint32_t> places_;  // of those
};

}  // namespace curvd
