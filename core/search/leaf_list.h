// The leaves of an index that may hold neighbors of a group of query points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Leaves in tree order with their boxes, coordinate by coordinate, for a vector test against a query's ball. Padded
// with boxes at infinity to a multiple of kPad.
// Not thread-safe.
class LeafList {
 public:
  static constexpr size_t kPad = 16;
  // Leaves that are looked at before a list that grew too long is given up.
  static constexpr size_t kMostTested = 2 * kPad;

  void Clear() { size_ = 0; }

  // To be called once all are added.
  void Pad();

  // For writers of whole vectors: room for `size` leaves and a vector more, the arrays, and how many of what was
  // written at their ends are kept.
  void Reserve(size_t size) {
    if (size + kPad > leaves_.capacity()) Grow(size);
  }
  uint32_t* end() { return leaves_.data() + size_; }
  float* lo_end(int axis) { return bounds_[axis].data() + size_; }
  float* hi_end(int axis) { return bounds_[3 + axis].data() + size_; }
  void Keep(size_t count) { size_ += count; }
  // Adds a leaf of `index`.
  void Add(const SpatialIndex& index, uint32_t leaf);

  size_t size() const { return size_; }
  // Changes with each Pad, so that what was made from a list can be told from what was made from its successor.
  uint64_t generation() const { return generation_; }
  size_t padded_size() const { return (size_ + kPad - 1) / kPad * kPad; }
  uint32_t leaf(size_t i) const { return leaves_[i]; }
  const uint32_t* leaves() const { return leaves_.data(); }
  const float* lo(int axis) const { return bounds_[axis].data(); }
  const float* hi(int axis) const { return bounds_[3 + axis].data(); }
  // Bytes that the list holds, and holds at most while it never had more than `size` leaves.
  size_t bytes() const { return leaves_.bytes() + 6 * bounds_[0].bytes(); }
  static constexpr size_t MostBytes(size_t size) { return 7 * ScratchArray<float>::MostBytes(size + 3 * kPad); }

 private:
  void Grow(size_t size);

  size_t size_ = 0;
  uint64_t generation_ = 0;
  ScratchArray<uint32_t> leaves_;
  ScratchArray<float> bounds_[6];
};

}  // namespace curvd
