// The samples nearest to each sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/paper/samples.h"
#include "bench/peers/packed_points.h"

namespace curvd::bench {

class NearestOfSamples {
 public:
  static_assert(sizeof(curv::Vec3) == 3 * sizeof(double));

  // REQUIRES: there is a sample. Refers to the samples.
  explicit NearestOfSamples(const Samples& samples)
      : samples_(samples),
        packed_{&samples.positions.front().x, samples.size()},
        tree_(3, packed_, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {}

  // Finds at most `count`, sample i included, nearest first, and their squared distances in squared length units.
  void Find(size_t i, size_t count, std::vector<uint32_t>& found, std::vector<double>& squared_distances) const {
    found.resize(count);
    squared_distances.resize(count);
    const size_t size = tree_.knnSearch(&samples_.positions[i].x, count, found.data(), squared_distances.data());
    found.resize(size);
    squared_distances.resize(size);
  }

 private:
  const Samples& samples_;
  PackedPoints<double> packed_;
  NanoflannTree<double> tree_;
};

}  // namespace curvd::bench
