// Draws a sample of points that depends on their numbers alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "client/tiles/box.h"

namespace curv {

// Keeps the points whose numbers have the smallest hashes: of two sizes, the smaller sample is the start of the larger
// one. Not thread-safe.
class PointSample {
 public:
  // Takes twice the memory of `size` points. REQUIRES: size is 1 or more.
  explicit PointSample(size_t size) : size_(size) {}

  void Add(uint64_t id, const Position& p) {
    const uint64_t hash = HashOf(id);
    if (hash >= limit_) return;
    kept_.emplace_back(hash, p);
    if (kept_.size() == 2 * size_) Shrink();
  }

  // The sample, or the first `most` points of it, in the order of the hashes. Called once. REQUIRES: most is 1 or more.
  std::vector<Position> Take(size_t most);

 private:
  using Kept = std::pair<uint64_t, Position>;

  static uint64_t HashOf(uint64_t id) {  // the finalizer of SplitMix64 (Steele et al. 2014), which maps one to one
    uint64_t z = id + 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  void Shrink();

  size_t size_;
  uint64_t limit_ = ~uint64_t{0};
  std::vector<Kept> kept_;
};

}  // namespace curv
