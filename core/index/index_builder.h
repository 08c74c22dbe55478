// Builds a SpatialIndex in phases of independent work blocks.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/stop_sign.h"
#include "core/cloud/cloud.h"
#include "core/cloud/point_record.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Usage: Start(); while (block_count() > 0) { run RunBlock(i) for each i < block_count(), in any order and on any
// threads; then EndPhase(). } Then Build(root()), and Build() each part that a Build() leaves, in any order and on any
// threads. Then Take(). The index depends on the cloud alone.
//
// RunBlock and Build are thread-safe; all else is not.
class IndexBuilder {
 public:
  // A node whose points are still to be split.
  struct Part {
    size_t node;
    size_t first_leaf;
    size_t leaves;
  };

  // Takes the cloud, whose records become the index's if they can. REQUIRES: cloud.Finish() was called.
  explicit IndexBuilder(Cloud cloud, StopSign stop = {});

  // Errors: ErrorKind::kOutOfMemory, the system gave no memory for the index; may throw std::bad_alloc instead. kRepeatedId:
  // two points of the cloud have the same id. Called once, before all else.
  absl::Status Start();

  // Blocks of the current phase; 0 once the tree can be built, which may be at once.
  size_t block_count() const { return block_count_; }
  void RunBlock(size_t block);
  void EndPhase();

  Part root() const { return {0, 0, index_.leaf_count()}; }
  // The part that `node` stands for. REQUIRES: the node is of this tree.
  Part PartOf(size_t node) const;
  // Builds the tree below `part`, or splits it and calls leave(half) for each half. Asks `stop` before each slice of at
  // most kSlicedRecords points (core/index/select_nth.h), and returns, without an index, once it is set: after the
  // slice at hand, which takes up to 20 milliseconds. So does a block of RunBlock, of Cloud::kBlockPoints points.
  void Build(const Part& part, absl::FunctionRef<void(const Part& half)> leave);

  // Bytes of the cloud and of the index together.
  size_t bytes() const { return cloud_.bytes() + index_.bytes(); }
  SpatialIndex Take() { return std::move(index_); }

 private:
  // Of records that the cloud could not give away.
  enum class Phase { kCount, kCollect, kDone };

  absl::Status MakeArrays(PageArray<PointRecord> records);
  void StartCollect();
  void CountBlock(size_t block);
  void CollectBlock(size_t block);
  // Sets the scale by the box of all points, and returns their box in the unit that records are then in.
  Box SetScale(const Box& box);
  int MagnifyingExponent(int scale_exponent) const;
  Box ScaleRecords();
  std::array<float, 3> Scaled(const std::array<float, 3>& position) const;
  TreeNode MeasureNode(const Part& part);
  void Split(const Part& part, Part* left, Part* right);
  void BuildSubtree(const Part& part);
  void FinishLeaf(size_t leaf);
  PointRecord* record(size_t leaf) { return records_ + leaf * SpatialIndex::kLeafSize; }
  PointRecord* PartEnd(const Part& part);
  const std::array<float, 3>& NormalOf(const PointRecord& record) const {
    return cloud_.normal(index_.point_set_.place_of(record.id));
  }

  Cloud cloud_;
  const StopSign stop_;
  SpatialIndex index_;
  PointRecord* records_ = nullptr;  // in the memory that becomes the index's positions
  std::array<float, 2> scale_{};    // 2^scale_exponent in two factors, each a float: their product may not be one
  Phase phase_ = Phase::kDone;
  size_t block_count_ = 0;
  std::vector<size_t> block_offsets_;  // valid points in each block of the cloud; then, in all blocks before it
};

}  // namespace curvd
