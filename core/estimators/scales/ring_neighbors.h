// The neighbors of one query at one scale after the other: those of the largest first, of which the next ones are a
// part.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/estimators/neighbors.h"

namespace curvd {

// Set by RingCollector and Narrow (core/estimators/scales/narrow-inl.h) for one query at a time. Not thread-safe.
struct RingNeighbors {
  NeighborArrays neighbors;      // of the scale at hand
  ScratchArray<float> squared;   // their distances; infinity follows the last one up to the end of a vector
  ScratchArray<int32_t> number;  // which of the largest scale's neighbors each of them is
  ScratchArray<int32_t> id;      // of the largest scale's neighbors, by number
  ScratchArray<int32_t> tied;    // ids of those at the distance of the last neighbor

  // Makes room for `size` neighbors of the largest scale.
  void Reserve(size_t size) {
    neighbors.Reserve(size);
    squared.Reserve(size + NeighborArrays::kPad);
    number.Reserve(size + NeighborArrays::kPad);
    id.Reserve(size + NeighborArrays::kPad);
  }
  // Bytes held, and held at most for so many neighbors.
  size_t bytes() const { return neighbors.bytes() + squared.bytes() + number.bytes() + id.bytes() + tied.bytes(); }
  static constexpr size_t MostBytes(size_t size) {
    return NeighborArrays::MostBytes(size) + 4 * ScratchArray<int32_t>::MostBytes(size + NeighborArrays::kPad);
  }
};

}  // namespace curvd
