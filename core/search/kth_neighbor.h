// The exact K-th neighbor of one point by descent of the tree: the path for queries whose surroundings are too uneven
// to share a list of leaves with their group.
#pragma once

#include <atomic>
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

// Below the rank of every point.
inline constexpr NeighborRank kNoRank{-1.0f, 0};

// What a descent of the tree tells and is told meanwhile.
struct DescentWatch {
  // Once true, the descent ends within 16 leaves. DEFAULT: never.
  const std::atomic<bool>* stopped = nullptr;
  // Gets a step for each node entered and each point looked at (SearchScratch::work). DEFAULT: nobody counts.
  uint64_t* work = nullptr;
};

// Returns the rank of the K-th nearest point: the K neighbors are the points of at most this rank; kNoRank if it was
// stopped. Distances are computed in float32 from the stored coordinates. `heap` is scratch, for k ranks. Throws
// std::bad_alloc.
// Expected O(log n + K log K), also where points coincide: subtrees that can only tie are skipped by their lowest id.
// Comes to every leaf, and no more, where the boxes of all are nearer than the K-th neighbor: from the center of a
// sphere of points.
// REQUIRES: 1 <= k <= index.point_count().
NeighborRank KthNeighbor(const SpatialIndex& index, const float query[3], size_t k, ScratchArray<NeighborRank>& heap,
                         DescentWatch watch = {});

}  // namespace curvd
