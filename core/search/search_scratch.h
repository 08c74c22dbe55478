// What the search of one thread keeps between its steps, and what it has found.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"
#include "core/search/kth_neighbor.h"
#include "core/search/leaf_list.h"
#include "core/search/neighbor_offsets.h"
#include "core/search/search_plan.h"

namespace curvd {

// The neighborhood that the last search found: the points of `leaves` whose rank is at most `last`. Read it through
// ForEachInside (core/search/neighborhood-inl.h), which alone decides who is inside. Valid until the next search.
struct Neighborhood {
  ScratchArray<uint32_t> leaves;          // in tree order, each once; some may hold no neighbor
  ScratchArray<uint32_t> positions;       // of each of `leaves` in the list that was searched (GroupSearch::leaves)
  ScratchArray<float> squared_distances;  // from the query to each point of `leaves`, kLeafSize a leaf
  size_t leaf_count = 0;                  // of `leaves`
  NeighborRank last{};                    // id kPaddingId: all points at its distance are inside
  size_t count = 0;                       // points inside
};

// The buffers that GroupSearch works with. What they hold between groups only seeds searches; results never depend on
// it. Not thread-safe.
struct SearchScratch {
  LeafList group_leaves;  // near the queries of a group
  LeafList query_leaves;  // of a query that shares no list: each of them holds a neighbor
  Neighborhood found;
  ScratchArray<float> inner_distances;  // squared, within the radius that was looked at; padded with infinity
  ScratchArray<int32_t> tied_ids;       // of points at the distance of the last neighbor
  ScratchArray<NeighborRank> heap;      // of the descent for the K-th neighbor
  NeighborOffsets offsets;              // of a query that was looked at once more
  float reach_hint = 0.0f;              // the largest squared distance of a neighbor in the last group; 0: unknown

  // Steps so far, each of a bounded number of operations: a node of the tree that was entered, a leaf whose box was
  // tested, a point of a leaf that was looked at, and what strategies count besides (their kernels say it). A measure
  // of cost that is the same on every machine with the same vectors; counted by the query, not by the step.
  uint64_t work = 0;

  // Once true, searches end early and what they find is worth nothing; null: never. Looked at within each descent of
  // the tree, which may come to every leaf; searches of a list are short.
  const std::atomic<bool>* stopped = nullptr;
  bool IsStopped() const { return stopped != nullptr && stopped->load(std::memory_order_relaxed); }

  // Bytes that the buffers hold.
  size_t bytes() const;
};

// Leaves that SearchScratch::found has at most, for an index of so many points.
size_t MostFoundLeaves(const SearchPlan& plan, size_t point_count);

// Bytes that the buffers of one search hold at most, for an index of so many points.
size_t SearchScratchBytes(const SearchPlan& plan, size_t point_count);

}  // namespace curvd
