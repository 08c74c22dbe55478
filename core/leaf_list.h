// The leaves of an index that may hold neighbors of a group of query points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/scratch_array.h"
#include "core/spatial_index.h"

namespace curvd {

// Leaves in tree order with their boxes, coordinate by coordinate, for a vector test against a query's ball. Padded
// with boxes at infinity to a multiple of kPad.
// Not thread-safe.
class LeafList {
 public:
  static constexpr size_t kPad = 16;

  // Replaces the list by the leaves at squared distance <= `squared_reach` of `box`. Every point whose computed squared
  // distance to a point of `box` is within it lies in one of them. Returns false, with the list undefined, if there
  // are more than `max_leaves`.
  bool Gather(const SpatialIndex& index, const Box& box, float squared_reach, size_t max_leaves);

  size_t size() const { return size_; }
  size_t padded_size() const { return (size_ + kPad - 1) / kPad * kPad; }
  uint32_t leaf(size_t i) const { return leaves_[i]; }
  const float* lo(int axis) const { return bounds_[axis].data(); }
  const float* hi(int axis) const { return bounds_[3 + axis].data(); }

 private:
  void Add(uint32_t leaf, const Box& box);
  void Pad();

  size_t size_ = 0;
  ScratchArray<uint32_t> leaves_;
  ScratchArray<float> bounds_[6];
};

}  // namespace curvd
