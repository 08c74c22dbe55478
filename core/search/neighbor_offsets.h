// The neighbors of a point that is looked at once more.
#pragma once

#include <cstddef>

#include "core/base/scratch_array.h"

namespace curvd {

// Offsets from the point, itself included, in the index's unit and in any order.
struct NeighborOffsets {
  ScratchArray<float> x, y, z;
  size_t count = 0;

  // Room behind the last one, for whole vectors.
  static constexpr size_t kPad = 16;

  void Reserve(size_t size) {
    for (auto* array : {&x, &y, &z}) array->Reserve(size + kPad);
  }
  // Bytes held, and held at most for so many neighbors.
  size_t bytes() const { return 3 * x.bytes(); }
  static constexpr size_t MostBytes(size_t size) { return 3 * ScratchArray<float>::MostBytes(size + kPad); }
};

}  // namespace curvd
