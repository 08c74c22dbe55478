#include "core/index_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/record_extent.h"

namespace curvd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Ranges up to this many leaves are built by one work block, in a few milliseconds.
constexpr size_t kSubtreeLeaves = 2048;

constexpr size_t kPrefetchLeaves = SpatialIndex::kGroupLeaves;

static_assert(sizeof(PointRecord) * SpatialIndex::kLeafSize == sizeof(SpatialIndex::LeafPositions),
              "a leaf is transposed in place");

constexpr Box kEmptyBox = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

void Extend(Box& box, const float* position) {
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = std::min(box.lo[axis], position[axis]);
    box.hi[axis] = std::max(box.hi[axis], position[axis]);
  }
}

void Extend(Box& box, const Box& other) {
  Extend(box, other.lo.data());
  Extend(box, other.hi.data());
}

int WidestAxis(const Box& box) {
  int widest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (box.hi[axis] - box.lo[axis] > box.hi[widest] - box.lo[widest]) widest = axis;
  }
  return widest;
}

// Copies up to a leaf's records in the order of their ids, so that the tree's order depends on the points alone, not on
// how the splits were found.
void SortById(const PointRecord* records, int count, PointRecord* sorted) {
  for (int i = 0; i < count; ++i) {
    int rank = 0;
    for (int j = 0; j < count; ++j) rank += records[j].id < records[i].id;
    sorted[rank] = records[i];
  }
}

bool IsValid(const OrientedPoint& point) { return !std::isnan(point.position[0]); }

// The exponent of the power of two that brings the largest extent of `box` into [0.5, 1); coordinates may stay larger
// where the cloud is far from zero.
int ScaleExponent(const Box& box) {
  double extent = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, static_cast<double>(box.hi[axis]) - box.lo[axis]);
  }
  if (extent == 0.0) return 0;
  int exponent = 0;
  std::frexp(extent, &exponent);
  return -exponent;
}

}  // namespace

IndexBuilder::IndexBuilder(const Cloud& cloud, const std::atomic<bool>* cancelled)
    : cloud_(cloud), cancelled_(cancelled) {
  block_count_ = (cloud.size() + Cloud::kBlockPoints - 1) / Cloud::kBlockPoints;
  extents_.resize(block_count_);
  if (block_count_ == 0) phase_ = Phase::kDone;
}

void IndexBuilder::RunBlock(size_t block) {
  switch (phase_) {
    case Phase::kMeasure:
      return MeasureBlock(block);
    case Phase::kCollect:
      return CollectBlock(block);
    case Phase::kSplit:
      return SplitRange(ranges_[block], &children_[2 * block], &children_[2 * block + 1]);
    case Phase::kSubtrees:
      return BuildSubtree(ranges_[block]);
    case Phase::kDone:
      return;
  }
}

absl::Status IndexBuilder::EndPhase() {
  switch (phase_) {
    case Phase::kMeasure:
      return StartCollect();
    case Phase::kCollect:
      ranges_ = {{0, 0, index_.leaf_count()}};
      StartSplit();
      break;
    case Phase::kSplit:
      ranges_ = std::move(children_);
      StartSplit();
      break;
    case Phase::kSubtrees:
      phase_ = Phase::kDone;
      block_count_ = 0;
      break;
    case Phase::kDone:
      break;
  }
  return absl::OkStatus();
}

absl::Status IndexBuilder::StartCollect() {
  Box box = kEmptyBox;
  for (const BlockExtent& extent : extents_) {
    block_offsets_.push_back(index_.point_count_);
    index_.point_count_ += extent.valid;
    if (extent.valid > 0) Extend(box, extent.box);
  }
  if (index_.point_count_ == 0) {
    phase_ = Phase::kDone;
    block_count_ = 0;
    return absl::OkStatus();
  }
  index_.scale_exponent_ = ScaleExponent(box);
  const size_t leaves = SpatialIndex::LeafCount(index_.point_count_);
  auto positions = PageArray<SpatialIndex::LeafPositions>::Create(leaves);
  if (!positions.ok()) return positions.status();
  auto normals = PageArray<SpatialIndex::LeafNormals>::Create(leaves);
  if (!normals.ok()) return normals.status();
  auto bounds = PageArray<float>::Create(6 * (leaves + SpatialIndex::kLeafSize));
  if (!bounds.ok()) return bounds.status();
  auto nodes = PageArray<TreeNode>::Create(2 * leaves - 1);
  if (!nodes.ok()) return nodes.status();
  index_.positions_ = *std::move(positions);
  index_.normals_ = *std::move(normals);
  index_.leaf_bounds_ = *std::move(bounds);
  index_.nodes_ = *std::move(nodes);
  records_ = reinterpret_cast<PointRecord*>(index_.positions_.data());
  phase_ = Phase::kCollect;
  return absl::OkStatus();
}

void IndexBuilder::StartSplit() {
  const size_t leaves = ranges_.front().leaves;  // the largest: splits differ by one leaf
  if (leaves > kSubtreeLeaves) {
    phase_ = Phase::kSplit;
    children_.assign(2 * ranges_.size(), {});
  } else {
    phase_ = Phase::kSubtrees;
  }
  block_count_ = ranges_.size();
}

void IndexBuilder::MeasureBlock(size_t block) {
  BlockExtent extent{kEmptyBox, 0};
  const size_t first = block * Cloud::kBlockPoints;
  const size_t last = std::min(first + Cloud::kBlockPoints, cloud_.size());
  for (size_t i = first; i < last; ++i) {
    const OrientedPoint& point = cloud_.point(i);
    if (!IsValid(point)) continue;
    Extend(extent.box, point.position.data());
    ++extent.valid;
  }
  extents_[block] = extent;
}

void IndexBuilder::CollectBlock(size_t block) {
  PointRecord* out = records_ + block_offsets_[block];
  const size_t first = block * Cloud::kBlockPoints;
  const size_t last = std::min(first + Cloud::kBlockPoints, cloud_.size());
  // Two factors, each a float: their product may not be one.
  const float half_scale = std::ldexp(1.0f, index_.scale_exponent_ / 2);
  const float other_scale = std::ldexp(1.0f, index_.scale_exponent_ - index_.scale_exponent_ / 2);
  for (size_t i = first; i < last; ++i) {
    const OrientedPoint& point = cloud_.point(i);
    if (!IsValid(point)) continue;
    for (int axis = 0; axis < 3; ++axis) out->position[axis] = point.position[axis] * half_scale * other_scale;
    out->id = static_cast<int32_t>(i);
    ++out;
  }
}

PointRecord* IndexBuilder::RangeEnd(const Range& range) {
  const size_t end = (range.first_leaf + range.leaves) * SpatialIndex::kLeafSize;
  return records_ + std::min(end, index_.point_count_);
}

TreeNode IndexBuilder::MeasureNode(const Range& range) {
  constexpr ptrdiff_t kSliceRecords = ptrdiff_t{4} << 20;  // 10 milliseconds
  TreeNode node{kEmptyBox, SpatialIndex::kPaddingId, 0};
  const PointRecord* end = RangeEnd(range);
  for (const PointRecord* slice = record(range.first_leaf); slice != end && !IsCancelled();) {
    const PointRecord* next = slice + std::min(kSliceRecords, end - slice);
    ExtendNode(slice, next, node);
    slice = next;
  }
  return node;
}

void IndexBuilder::SplitRange(const Range& range, Range* left, Range* right) {
  TreeNode& node = index_.nodes_[range.node];
  node = MeasureNode(range);
  const size_t left_leaves = SpatialIndex::LeftLeaves(range.leaves);
  *left = {range.node + 1, range.first_leaf, left_leaves};
  *right = {SpatialIndex::RightChild(range.node, range.leaves), range.first_leaf + left_leaves,
            range.leaves - left_leaves};
  SelectNth(record(range.first_leaf), record(right->first_leaf), RangeEnd(range), WidestAxis(node.box), cancelled_);
}

void IndexBuilder::BuildSubtree(const Range& range) {
  if (range.leaves == 1) {
    const TreeNode& node = index_.nodes_[range.node] = MeasureNode(range);
    for (int axis = 0; axis < 3; ++axis) {
      index_.leaf_bounds_[axis * index_.bounds_stride() + range.first_leaf] = node.box.lo[axis];
      index_.leaf_bounds_[(3 + axis) * index_.bounds_stride() + range.first_leaf] = node.box.hi[axis];
    }
    FinishLeaf(range.first_leaf);
    return;
  }
  if (range.leaves == kPrefetchLeaves) {
    // Normals lie in input order; fetch them while the last splits are made.
    const PointRecord* end = RangeEnd(range);
    for (const PointRecord* it = record(range.first_leaf); it != end; ++it) __builtin_prefetch(&cloud_.point(it->id));
  }
  Range left, right;
  SplitRange(range, &left, &right);
  BuildSubtree(left);
  BuildSubtree(right);
}

void IndexBuilder::FinishLeaf(size_t leaf) {
  constexpr int kSize = SpatialIndex::kLeafSize;
  const int count = index_.LeafPoints(leaf);
  PointRecord records[kSize];
  SortById(record(leaf), count, records);
  std::fill(records + count, records + kSize, PointRecord{{kInfinity, kInfinity, kInfinity}, SpatialIndex::kPaddingId});
  SpatialIndex::LeafPositions positions;
  SpatialIndex::LeafNormals normals{};
  for (int i = 0; i < kSize; ++i) {
    positions.x[i] = records[i].position[0];
    positions.y[i] = records[i].position[1];
    positions.z[i] = records[i].position[2];
    positions.id[i] = records[i].id;
    if (i >= count) continue;
    const std::array<float, 3>& normal = cloud_.point(records[i].id).normal;
    normals.x[i] = normal[0];
    normals.y[i] = normal[1];
    normals.z[i] = normal[2];
  }
  index_.positions_[leaf] = positions;
  index_.normals_[leaf] = normals;
}

}  // namespace curvd
