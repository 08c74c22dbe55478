// What estimators take of the neighbors of a query.
#pragma once

#include <cstddef>

#include "core/base/scratch_array.h"

namespace curvd {

// The point whose neighbors are looked at.
struct QueryPoint {
  float position[3];  // in the index's unit
  float normal[3];    // of unit length
};

// What the normals of one query's neighbors, itself among them, come to.
struct NormalSums {
  float sum[3];
  float least_agreement;  // the least cosine between one of them and the query's own
};

// For searches that take no normals.
inline constexpr NormalSums kNoNormals{{}, 1.0f};

// The neighbors of one query in tree order: their offsets from it, in the index's unit, and their normals. Set by
// NeighborCollector (core/estimators/neighbors/neighbors-inl.h) for one query at a time; zeros follow the last neighbor
// up to the end of a vector.
struct NeighborArrays {
  ScratchArray<float> dx, dy, dz;
  ScratchArray<float> nx, ny, nz;
  size_t count = 0;

  // Elements that follow the last neighbor.
  static constexpr size_t kPad = 16;

  // Makes room for `size` neighbors, and the padding.
  void Reserve(size_t size) {
    for (auto* array : {&dx, &dy, &dz, &nx, &ny, &nz}) array->Reserve(size + kPad);
  }
  // Bytes held, and held at most for so many neighbors.
  size_t bytes() const { return 6 * dx.bytes(); }
  static constexpr size_t MostBytes(size_t size) { return 6 * ScratchArray<float>::MostBytes(size + kPad); }
};

}  // namespace curvd
