// The K nearest of what a search offers, in a binary heap: an insertion costs log K where nanoflann's own, which keeps
// them sorted, costs K.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace curvd::bench {

class HeapResultSet {
 public:
  explicit HeapResultSet(size_t capacity) : heap_(capacity), indices_(capacity) {}

  void Clear() { size_ = 0; }
  // In no order. REQUIRES: full().
  const uint32_t* indices() {
    for (size_t i = 0; i < size_; ++i) indices_[i] = heap_[i].index;
    return indices_.data();
  }

  // What nanoflann calls, by its names.
  size_t size() const { return size_; }
  bool full() const { return size_ == heap_.size(); }
  float worstDist() const { return full() ? heap_[0].distance : std::numeric_limits<float>::max(); }
  bool addPoint(float distance, uint32_t index) {
    if (!full()) {
      SiftUp({distance, index});
    } else if (distance < heap_[0].distance) {
      SiftDown({distance, index});
    }
    return true;
  }

 private:
  struct Entry {
    float distance;
    uint32_t index;
  };

  void SiftUp(Entry entry) {
    size_t hole = size_++;
    for (; hole > 0 && heap_[(hole - 1) / 2].distance < entry.distance; hole = (hole - 1) / 2) {
      heap_[hole] = heap_[(hole - 1) / 2];
    }
    heap_[hole] = entry;
  }

  // Replaces the farthest entry.
  void SiftDown(Entry entry) {
    size_t hole = 0;
    for (size_t child = 1; child < size_; child = 2 * hole + 1) {
      child += child + 1 < size_ && heap_[child + 1].distance > heap_[child].distance;
      if (heap_[child].distance <= entry.distance) break;
      heap_[hole] = heap_[child];
      hole = child;
    }
    heap_[hole] = entry;
  }

  std::vector<Entry> heap_;
  std::vector<uint32_t> indices_;
  size_t size_ = 0;
};

}  // namespace curvd::bench
