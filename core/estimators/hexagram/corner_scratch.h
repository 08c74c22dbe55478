// What the search for the corners of hexagrams keeps between its steps.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"
#include "core/search/leaf_list.h"

namespace curvd {

// The points of one leaf relative to a center, and their squared distances from it.
struct alignas(64) CenteredLeaf {
  float x[SpatialIndex::kLeafSize];
  float y[SpatialIndex::kLeafSize];
  float z[SpatialIndex::kLeafSize];
  float squared_norm[SpatialIndex::kLeafSize];
};

// What it holds between groups only seeds searches. Not thread-safe.
struct CornerScratch {
  // Leaves in one list around the targets of all corners, of one corner, and of one patch that no list served.
  static constexpr size_t kMaxShared = 256, kMaxSingle = 512, kMaxPatch = 512;
  // Lists of more leaves are not centered.
  static constexpr size_t kMaxCentered = 64;

  LeafList leaves;                      // near the targets of all corners, or of one
  LeafList corner_leaves;               // of `leaves`, those near the targets of one corner
  LeafList patch_leaves;                // near the targets of one patch that no list served
  ScratchArray<CenteredLeaf> centered;  // the leaves that were listed for the targets of one corner
  ScratchArray<uint32_t> near;          // places in a list of the leaves near the targets of one patch
  // Within how much of each corner's last targets there was a point: squared, in units of squared spacing. In the
  // plane, one hole in 150 of a random cloud is larger than 5.
  float target_reach[6] = {5, 5, 5, 5, 5, 5};

  size_t bytes() const {
    return leaves.bytes() + corner_leaves.bytes() + patch_leaves.bytes() + centered.bytes() + near.bytes();
  }
  static size_t MostBytes(size_t point_count) {
    const size_t listed = std::min(kMaxSingle + LeafList::kMostTested, SpatialIndex::LeafCount(point_count));
    return 3 * LeafList::MostBytes(listed) + ScratchArray<CenteredLeaf>::MostBytes(kMaxCentered) +
           ScratchArray<uint32_t>::MostBytes(listed + 2 * LeafList::kPad);
  }
};

}  // namespace curvd
