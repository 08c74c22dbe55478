// The points of one group of leaves, which are estimated together.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/estimators/curvature_field.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A quantity of each point of a group. Arrays of these stay aligned for any vector; what lies at GroupPoints::size and
// beyond is loaded with whole vectors, and is never used.
using GroupScalars = float[SpatialIndex::kGroupPoints];

// A vector quantity of each point of a group.
struct alignas(64) GroupVectors {
  GroupScalars x, y, z;

  void Set(size_t i, const float* v) {
    x[i] = v[0];
    y[i] = v[1];
    z[i] = v[2];
  }
  // Copies the vector of point i to to[0..2].
  void Get(size_t i, float* to) const {
    to[0] = x[i];
    to[1] = y[i];
    to[2] = z[i];
  }
};

// Set by LoadGroup (core/estimators/group_points-inl.h).
struct GroupPoints {
  static constexpr size_t kNoSlot = ~size_t{0};

  size_t size = 0;
  Box box;                                    // of the points
  GroupVectors query;                         // position, in the index's unit
  GroupVectors normal;                        // the point's own, of unit length
  int32_t rank[SpatialIndex::kGroupPoints];   // decides between equal distances
  size_t slot[SpatialIndex::kGroupPoints];    // where the result goes; kNoSlot where there will be none
  int32_t place[SpatialIndex::kGroupPoints];  // in the tree order
  // Set once a point's neighborhood is known (PreparePoints), and lowered by what finds that it has no curvature.
  PointStatus status[SpatialIndex::kGroupPoints];
};

}  // namespace curvd
