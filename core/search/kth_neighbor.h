// The exact K-th neighbor of one point by descent of the tree: the path for queries whose surroundings are too uneven
// to share a list of leaves with their group.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A point's rank among the neighbors of a query: nearer first, then the lower id.
struct NeighborRank {
  float squared_distance;
  int32_t id;

  friend bool operator<(const NeighborRank& a, const NeighborRank& b) {
    return a.squared_distance < b.squared_distance || (a.squared_distance == b.squared_distance && a.id < b.id);
  }
};

// Returns the rank of the K-th nearest point: the K neighbors are the points of at most this rank. Distances are
// computed in float32 from the stored coordinates. `heap` is scratch, for k ranks. Throws std::bad_alloc.
// Expected O(log n + K log K), also where points coincide: subtrees that can only tie are skipped by their lowest id.
// REQUIRES: 1 <= k <= index.point_count().
NeighborRank KthNeighbor(const SpatialIndex& index, const float query[3], size_t k, ScratchArray<NeighborRank>& heap);

}  // namespace curvd
