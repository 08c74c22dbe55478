// Builds a SpatialIndex in phases of independent work blocks.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "core/cloud.h"
#include "core/select_nth.h"
#include "core/spatial_index.h"

namespace curvd {

// Usage: while (block_count() > 0) { run RunBlock(i) for each i < block_count(), in any order and on any threads;
// then EndPhase(). } Then Take(). The index depends on the cloud alone.
//
// RunBlock is thread-safe; all else is not.
class IndexBuilder {
 public:
  // REQUIRES: cloud.Finish() was called; the cloud, and `cancelled` if there is one, outlive the builder.
  explicit IndexBuilder(const Cloud& cloud, const std::atomic<bool>* cancelled = nullptr);

  // Blocks of the current phase; 0 when the index is complete.
  size_t block_count() const { return block_count_; }
  // Once `cancelled` is true, returns within tens of milliseconds, and there will be no index.
  void RunBlock(size_t block);
  // RESOURCE_EXHAUSTED if there is no memory for the next phase.
  absl::Status EndPhase();
  SpatialIndex Take() { return std::move(index_); }

 private:
  enum class Phase { kMeasure, kCollect, kSplit, kSubtrees, kDone };

  // A node whose points are still to be split.
  struct Range {
    size_t node;
    size_t first_leaf;
    size_t leaves;
  };
  // What one block of the cloud holds.
  struct BlockExtent {
    Box box;
    size_t valid;
  };

  absl::Status StartCollect();
  void StartSplit();
  void MeasureBlock(size_t block);
  void CollectBlock(size_t block);
  TreeNode MeasureNode(const Range& range);
  void SplitRange(const Range& range, Range* left, Range* right);
  void BuildSubtree(const Range& range);
  void FinishLeaf(size_t leaf);
  PointRecord* record(size_t leaf) { return records_ + leaf * SpatialIndex::kLeafSize; }
  PointRecord* RangeEnd(const Range& range);

  bool IsCancelled() const { return cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed); }

  const Cloud& cloud_;
  const std::atomic<bool>* cancelled_;
  SpatialIndex index_;
  PointRecord* records_ = nullptr;  // in the memory that becomes the index's positions
  Phase phase_ = Phase::kMeasure;
  size_t block_count_ = 0;
  std::vector<BlockExtent> extents_;
  std::vector<size_t> block_offsets_;  // of each block's first valid point among all valid points
  std::vector<Range> ranges_;          // kSplit and kSubtrees: the blocks of the phase
  std::vector<Range> children_;        // kSplit: two for each block
};

}  // namespace curvd
