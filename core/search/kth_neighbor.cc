#include "core/search/kth_neighbor.h"

#include <algorithm>

namespace curvd {
namespace {

// The K best ranks seen so far, the worst on top.
class Descent {
 public:
  Descent(const SpatialIndex& index, const float* query, size_t k, ScratchArray<NeighborRank>& heap)
      : index_(index), query_(query), k_(k), heap_(heap) {
    heap_.Reserve(k);
  }

  // The best rank that a point below the node may have.
  NeighborRank Bound(size_t node) const {
    const TreeNode& tree_node = index_.node(node);
    return {SquaredDistance(query_, tree_node.box), tree_node.min_id};
  }

  void Visit(size_t node, size_t first_leaf, size_t leaves) {
    if (leaves == 1) return ScanLeaf(first_leaf);
    const size_t left_leaves = SpatialIndex::LeftLeaves(leaves);
    const size_t left = node + 1;
    const size_t right = SpatialIndex::RightChild(node, leaves);
    const NeighborRank left_bound = Bound(left), right_bound = Bound(right);
    const auto visit_left = [&] {
      if (MayImprove(left_bound)) Visit(left, first_leaf, left_leaves);
    };
    const auto visit_right = [&] {
      if (MayImprove(right_bound)) Visit(right, first_leaf + left_leaves, leaves - left_leaves);
    };
    if (right_bound < left_bound) {
      visit_right();
      visit_left();
    } else {
      visit_left();
      visit_right();
    }
  }

 private:
  bool MayImprove(const NeighborRank& bound) const { return size_ < k_ || bound < heap_[0]; }

  void ScanLeaf(size_t leaf) {
    const SpatialIndex::LeafPositions& points = index_.positions(leaf);
    const int count = index_.LeafPoints(leaf);
    for (int i = 0; i < count; ++i) {
      const float dx = points.x[i] - query_[0], dy = points.y[i] - query_[1], dz = points.z[i] - query_[2];
      const NeighborRank rank{(dx * dx + dy * dy) + dz * dz, points.id[i]};
      if (!MayImprove(rank)) continue;
      NeighborRank* const ranks = heap_.data();
      if (size_ == k_) {
        std::pop_heap(ranks, ranks + size_);
      } else {
        ++size_;
      }
      ranks[size_ - 1] = rank;
      std::push_heap(ranks, ranks + size_);
    }
  }

  const SpatialIndex& index_;
  const float* query_;
  const size_t k_;
  ScratchArray<NeighborRank>& heap_;
  size_t size_ = 0;  // of the heap
};

}  // namespace

NeighborRank KthNeighbor(const SpatialIndex& index, const float query[3], size_t k, ScratchArray<NeighborRank>& heap) {
  Descent descent(index, query, k, heap);
  descent.Visit(0, 0, index.leaf_count());
  return heap[0];
}

}  // namespace curvd
