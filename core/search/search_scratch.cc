#include "core/search/search_scratch.h"

#include <algorithm>

namespace curvd {

size_t SearchScratch::bytes() const {
  return group_leaves.bytes() + query_leaves.bytes() + found.leaves.bytes() + found.positions.bytes() +
         found.squared_distances.bytes() + inner_distances.bytes() + tied_ids.bytes() + heap.bytes() + offsets.bytes();
}

namespace {

// Leaves of the list of a group. It is given up once it is too long, which is noticed after a run of leaves.
size_t MostListed(const SearchPlan& plan, size_t leaf_count) {
  return std::min(plan.max_listed_leaves() + LeafList::kMostTested, leaf_count);
}

// Leaves of the list of a query on its own: those with a neighbor, and with the one too many that ends the search.
size_t MostOwn(const SearchPlan& plan, size_t point_count) {
  return std::min(plan.MostNeighbors(point_count) + 1, SpatialIndex::LeafCount(point_count));
}

}  // namespace

size_t MostFoundLeaves(const SearchPlan& plan, size_t point_count) {
  return std::max(MostListed(plan, SpatialIndex::LeafCount(point_count)), MostOwn(plan, point_count));
}

size_t SearchScratchBytes(const SearchPlan& plan, size_t point_count) {
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  const size_t found = MostFoundLeaves(plan, point_count);
  size_t bytes = LeafList::MostBytes(MostListed(plan, SpatialIndex::LeafCount(point_count))) +
                 LeafList::MostBytes(MostOwn(plan, point_count));
  bytes += 2 * ScratchArray<uint32_t>::MostBytes(found + 2 * LeafList::kPad);  // leaves, positions
  bytes += ScratchArray<float>::MostBytes((found + 1) * kLeaf);                // squared distances
  bytes += ScratchArray<float>::MostBytes((found + 2) * kLeaf);                // inner distances
  bytes += NeighborOffsets::MostBytes(plan.MostNeighbors(point_count));
  if (!plan.by_radius) {
    bytes += ScratchArray<int32_t>::MostBytes(found * kLeaf);                         // tied ids
    bytes += ScratchArray<NeighborRank>::MostBytes(plan.MostNeighbors(point_count));  // heap
  }
  return bytes;
}

}  // namespace curvd
