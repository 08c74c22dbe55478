#include "core/index/index_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/index/record_extent.h"

namespace curvd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Parts up to this many leaves are built in one go, in a millisecond or two.
constexpr size_t kSubtreeLeaves = 1024;

constexpr size_t kPrefetchLeaves = SpatialIndex::kGroupLeaves;

static_assert(sizeof(PointRecord) * SpatialIndex::kLeafSize == sizeof(SpatialIndex::LeafPositions),
              "a leaf is transposed in place");

constexpr Box kEmptyBox = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

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

bool IsValid(const PointRecord& record) { return !std::isnan(record.position[0]); }

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

IndexBuilder::IndexBuilder(Cloud cloud, StopSign stop) : cloud_(std::move(cloud)), stop_(stop) {}

absl::Status IndexBuilder::Start() {
  if (absl::Status status = cloud_.Rank(); !status.ok()) return status;
  index_.point_count_ = cloud_.size() - cloud_.invalid_count();
  index_.point_set_ = cloud_.TakePointSet();
  if (index_.point_count_ == 0) return absl::OkStatus();
  PageArray<PointRecord> records = cloud_.TakeRecords();
  if (records.size() == 0) {
    phase_ = Phase::kCount;
    block_count_ = (cloud_.size() + Cloud::kBlockPoints - 1) / Cloud::kBlockPoints;
    block_offsets_.resize(block_count_);
  }
  return MakeArrays(std::move(records));
}

void IndexBuilder::RunBlock(size_t block) {
  switch (phase_) {
    case Phase::kCount:
      return CountBlock(block);
    case Phase::kCollect:
      return CollectBlock(block);
    case Phase::kDone:
      return;
  }
}

void IndexBuilder::EndPhase() {
  switch (phase_) {
    case Phase::kCount:
      StartCollect();
      break;
    case Phase::kCollect:
      phase_ = Phase::kDone;
      block_count_ = 0;
      break;
    case Phase::kDone:
      break;
  }
}

absl::Status IndexBuilder::MakeArrays(PageArray<PointRecord> records) {
  const size_t leaves = SpatialIndex::LeafCount(index_.point_count_);
  index_.positions_ = std::move(records).Recast<SpatialIndex::LeafPositions>();
  if (index_.positions_.size() == 0) {
    auto positions = PageArray<SpatialIndex::LeafPositions>::Create(leaves);
    if (!positions.ok()) return positions.status();
    index_.positions_ = *std::move(positions);
  }
  auto normals = PageArray<SpatialIndex::LeafNormals>::Create(cloud_.has_normals() ? leaves : 0);
  if (!normals.ok()) return normals.status();
  auto bounds = PageArray<float>::Create(6 * (leaves + SpatialIndex::kLeafSize));
  if (!bounds.ok()) return bounds.status();
  auto nodes = PageArray<TreeNode>::Create(2 * leaves - 1);
  if (!nodes.ok()) return nodes.status();
  index_.normals_ = *std::move(normals);
  index_.leaf_bounds_ = *std::move(bounds);
  index_.nodes_ = *std::move(nodes);
  records_ = reinterpret_cast<PointRecord*>(index_.positions_.data());
  return absl::OkStatus();
}

void IndexBuilder::StartCollect() {
  size_t offset = 0;
  for (size_t& block : block_offsets_) offset += std::exchange(block, offset);
  phase_ = Phase::kCollect;
}

void IndexBuilder::CountBlock(size_t block) {
  const size_t first = block * Cloud::kBlockPoints;
  const size_t last = std::min(first + Cloud::kBlockPoints, cloud_.size());
  size_t valid = 0;
  for (size_t i = first; i < last; ++i) valid += IsValid(cloud_.record(i)) ? 1 : 0;
  block_offsets_[block] = valid;
}

void IndexBuilder::CollectBlock(size_t block) {
  PointRecord* out = records_ + block_offsets_[block];
  const size_t first = block * Cloud::kBlockPoints;
  const size_t last = std::min(first + Cloud::kBlockPoints, cloud_.size());
  for (size_t i = first; i < last; ++i) {
    if (IsValid(cloud_.record(i))) *out++ = cloud_.record(i);
  }
}

// Returns by how many powers of two the index is to be larger than `scale_exponent` makes it, which comes from the
// extent. A float has small offsets near the origin alone, so that the magnitude of a point tells how small the
// structure around it can be. Of the scales at which the fewest sampled points are too small or too far, the one that
// is nearest to the extent's; for clouds without far outliers that is the extent's own.
int IndexBuilder::MagnifyingExponent(int scale_exponent) const {
  constexpr int kLeast = -37, kMost = 50;  // exponents of magnitudes in the index; 2^kMost is kFarthest
  constexpr size_t kMostSampled = 4096;
  constexpr int kRange = 320;            // exponents of floats differ by less
  std::array<uint32_t, kRange> below{};  // sampled points by exponents that they lack to 0
  uint32_t sampled = 0, weyl = 0x2545F491u;
  for (size_t i = 0; i < std::min(kMostSampled, index_.point_count_); ++i) {
    weyl += 0x9E3779B9u;
    const PointRecord& point = records_[(uint64_t{weyl} * index_.point_count_) >> 32];
    const float magnitude =
        std::max({std::abs(point.position[0]), std::abs(point.position[1]), std::abs(point.position[2])});
    if (magnitude == 0.0f) continue;  // has no structure, or that of others
    int exponent = 0;
    std::frexp(magnitude, &exponent);
    ++below[std::clamp(-(exponent + scale_exponent), 0, kRange - 1)];
    ++sampled;
  }
  int best = 0;
  uint32_t most_kept = 0;
  for (int magnified = 0; magnified < kRange && most_kept < sampled; ++magnified) {
    uint32_t kept = 0;
    const int last = std::min(magnified - kLeast, kRange - 1);
    for (int lack = std::max(magnified - kMost, 0); lack <= last; ++lack) kept += below[lack];
    if (kept <= most_kept) continue;
    most_kept = kept;
    best = magnified;
  }
  return best;
}

// Scales the records themselves, so that those which the scale makes equal are in the order of their ids among their
// likes. Returns their box.
Box IndexBuilder::ScaleRecords() {
  constexpr float kFarthest = SpatialIndex::kFarthest;
  constexpr float kNearest = 0x1p-63f;  // below it squares vanish
  Box box = kEmptyBox;
  for (size_t i = 0; i < index_.point_count_; ++i) {
    if (i % Cloud::kBlockPoints == 0 && stop_.IsSetBefore(std::min(Cloud::kBlockPoints, index_.point_count() - i))) {
      break;
    }
    const std::array<float, 3> scaled =
        Scaled({records_[i].position[0], records_[i].position[1], records_[i].position[2]});
    for (int axis = 0; axis < 3; ++axis) {
      const float coordinate =
          std::abs(scaled[axis]) < kNearest ? 0.0f : std::clamp(scaled[axis], -kFarthest, kFarthest);
      records_[i].position[axis] = coordinate;
      box.lo[axis] = std::min(box.lo[axis], coordinate);
      box.hi[axis] = std::max(box.hi[axis], coordinate);
    }
  }
  scale_ = {1.0f, 1.0f};
  return box;
}

Box IndexBuilder::SetScale(const Box& box) {
  index_.scale_exponent_ = ScaleExponent(box);
  const int magnifying = MagnifyingExponent(index_.scale_exponent_);
  index_.scale_exponent_ += magnifying;
  index_.lattice_spacing_ = static_cast<float>(std::ldexp(cloud_.lattice_spacing(), index_.scale_exponent_));
  const int half = index_.scale_exponent_ / 2;
  scale_ = {std::ldexp(1.0f, half), std::ldexp(1.0f, index_.scale_exponent_ - half)};
  return magnifying > 0 ? ScaleRecords() : box;
}

std::array<float, 3> IndexBuilder::Scaled(const std::array<float, 3>& position) const {
  return {position[0] * scale_[0] * scale_[1], position[1] * scale_[0] * scale_[1],
          position[2] * scale_[0] * scale_[1]};
}

PointRecord* IndexBuilder::PartEnd(const Part& part) {
  const size_t end = (part.first_leaf + part.leaves) * SpatialIndex::kLeafSize;
  return records_ + std::min(end, index_.point_count_);
}

TreeNode IndexBuilder::MeasureNode(const Part& part) {
  TreeNode node{kEmptyBox, SpatialIndex::kPaddingId, 0};
  const PointRecord* end = PartEnd(part);
  for (const PointRecord* slice = record(part.first_leaf); slice != end;) {
    const size_t size = std::min(kSlicedRecords, static_cast<size_t>(end - slice));
    if (stop_.IsSetBefore(size)) break;
    ExtendNode(slice, slice + size, node);
    slice += size;
  }
  // The root comes first.
  if (part.node == 0) node.box = SetScale(node.box);
  node.box = {Scaled(node.box.lo), Scaled(node.box.hi)};
  return node;
}

void IndexBuilder::Split(const Part& part, Part* left, Part* right) {
  TreeNode& node = index_.nodes_[part.node];
  node = MeasureNode(part);
  const size_t left_leaves = SpatialIndex::LeftLeaves(part.leaves);
  *left = {part.node + 1, part.first_leaf, left_leaves};
  *right = {SpatialIndex::RightChild(part.node, part.leaves), part.first_leaf + left_leaves, part.leaves - left_leaves};
  SelectNth(record(part.first_leaf), record(right->first_leaf), PartEnd(part), WidestAxis(node.box), stop_);
}

IndexBuilder::Part IndexBuilder::PartOf(size_t node) const {
  Part part = root();
  while (part.node != node) {
    const size_t left = SpatialIndex::LeftLeaves(part.leaves), right = SpatialIndex::RightChild(part.node, part.leaves);
    part = node < right ? Part{part.node + 1, part.first_leaf, left}
                        : Part{right, part.first_leaf + left, part.leaves - left};
  }
  return part;
}

void IndexBuilder::Build(const Part& part, absl::FunctionRef<void(const Part& half)> leave) {
  if (part.leaves == 0) return;
  if (part.leaves <= kSubtreeLeaves) return BuildSubtree(part);
  Part left, right;
  Split(part, &left, &right);
  leave(left);
  leave(right);
}

void IndexBuilder::BuildSubtree(const Part& part) {
  if (part.leaves == 1) {
    const TreeNode& node = index_.nodes_[part.node] = MeasureNode(part);
    for (int axis = 0; axis < 3; ++axis) {
      index_.leaf_bounds_[axis * index_.bounds_stride() + part.first_leaf] = node.box.lo[axis];
      index_.leaf_bounds_[(3 + axis) * index_.bounds_stride() + part.first_leaf] = node.box.hi[axis];
    }
    FinishLeaf(part.first_leaf);
    return;
  }
  if (part.leaves == kPrefetchLeaves && cloud_.has_normals()) {
    // Normals lie in input order; fetch them while the last splits are made.
    const PointRecord* end = PartEnd(part);
    for (const PointRecord* it = record(part.first_leaf); it != end; ++it) __builtin_prefetch(&NormalOf(*it));
  }
  Part left, right;
  Split(part, &left, &right);
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
    positions.x[i] = records[i].position[0] * scale_[0] * scale_[1];
    positions.y[i] = records[i].position[1] * scale_[0] * scale_[1];
    positions.z[i] = records[i].position[2] * scale_[0] * scale_[1];
    positions.id[i] = records[i].id;
    if (i >= count || !cloud_.has_normals()) continue;
    const std::array<float, 3>& normal = NormalOf(records[i]);
    normals.x[i] = normal[0];
    normals.y[i] = normal[1];
    normals.z[i] = normal[2];
  }
  index_.positions_[leaf] = positions;
  if (cloud_.has_normals()) index_.normals_[leaf] = normals;
}

}  // namespace curvd
