#include "core/search/kth_neighbor.h"

#include <algorithm>
#include <array>

namespace curvd {
namespace {

// The K best ranks seen so far, the worst on top.
class Descent {
 public:
  Descent(const SpatialIndex& index, const float* query, size_t k, ScratchArray<NeighborRank>& heap,
          const std::atomic<bool>* stopped)
      : index_(index), query_(query), k_(k), heap_(heap), stopped_(stopped) {
    heap_.Reserve(k);
  }

  // Looks at nodes in the order of their bounds, so that none is entered that holds no better point than the K-th. That
  // matters where a point coincides with many others and has as many that are all equally far: going down to the first
  // leaf and back up would look at all of the latter.
  void Run() {
    Push({Bound(0), 0, 0, static_cast<uint32_t>(index_.leaf_count())});
    while (waiting_ > 0 && !IsStopped()) {
      std::pop_heap(nodes_.begin(), nodes_.begin() + waiting_, IsWorse);
      const Node next = nodes_[--waiting_];
      if (!MayImprove(next.bound)) return;
      if (next.leaves <= kFewLeaves || waiting_ + 2 > nodes_.size()) {
        Visit(next.node, next.first_leaf, next.leaves);
      } else {
        PushChildren(next);
      }
    }
  }

  bool IsStopped() const { return stopped_ != nullptr && stopped_->load(std::memory_order_relaxed); }
  // Nodes entered, and points looked at.
  uint64_t work() const { return work_; }

 private:
  struct Node {
    NeighborRank bound;
    uint32_t node;
    uint32_t first_leaf;
    uint32_t leaves;
  };
  // Gone down at once: cheaper than to let their nodes wait.
  static constexpr uint32_t kFewLeaves = 16;
  // Where more nodes wait, one is gone down at once.
  static constexpr size_t kMostWaiting = 2048;

  static bool IsWorse(const Node& a, const Node& b) { return b.bound < a.bound; }

  void Push(const Node& node) {
    if (!MayImprove(node.bound)) return;
    nodes_[waiting_++] = node;
    std::push_heap(nodes_.begin(), nodes_.begin() + waiting_, IsWorse);
  }

  void PushChildren(const Node& parent) {
    ++work_;
    const auto left_leaves = static_cast<uint32_t>(SpatialIndex::LeftLeaves(parent.leaves));
    const uint32_t left = parent.node + 1;
    const auto right = static_cast<uint32_t>(SpatialIndex::RightChild(parent.node, parent.leaves));
    Push({Bound(left), left, parent.first_leaf, left_leaves});
    Push({Bound(right), right, parent.first_leaf + left_leaves, parent.leaves - left_leaves});
  }

  // The best rank that a point below the node may have.
  NeighborRank Bound(size_t node) const {
    const TreeNode& tree_node = index_.node(node);
    return {SquaredDistance(query_, tree_node.box), tree_node.min_id};
  }

  void Visit(size_t node, size_t first_leaf, size_t leaves) {
    ++work_;
    if (leaves == 1) return ScanLeaf(first_leaf);
    if (leaves > kFewLeaves && IsStopped()) return;
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

  bool MayImprove(const NeighborRank& bound) const { return size_ < k_ || bound < heap_[0]; }

  void ScanLeaf(size_t leaf) {
    const SpatialIndex::LeafPositions& points = index_.positions(leaf);
    const int count = index_.LeafPoints(leaf);
    work_ += static_cast<uint64_t>(count);
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
  const std::atomic<bool>* stopped_;
  uint64_t work_ = 0;
  size_t size_ = 0;                       // of the heap
  std::array<Node, kMostWaiting> nodes_;  // a heap, the best bound on top
  size_t waiting_ = 0;
};

}  // namespace

NeighborRank KthNeighbor(const SpatialIndex& index, const float query[3], size_t k, ScratchArray<NeighborRank>& heap,
                         DescentWatch watch) {
  Descent descent(index, query, k, heap, watch.stopped);
  descent.Run();
  if (watch.work != nullptr) *watch.work += descent.work();
  return descent.IsStopped() ? kNoRank : heap[0];
}

}  // namespace curvd
