// A balanced kd-tree over a cloud whose leaves are blocks that a SIMD kernel scans whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/point_record.h"
#include "core/cloud/point_set.h"

namespace curvd {

// Axis-aligned box, closed.
struct Box {
  std::array<float, 3> lo;
  std::array<float, 3> hi;
};

// A node's tight box, and the lowest point id below it, which breaks ties in distance.
struct TreeNode {
  Box box;
  int32_t min_id;
  int32_t reserved;
};

// Points in tree order, in units of 2^-scale_exponent of the cloud's own, which brings the cloud's extent near 1: a
// change that rounds nothing and lets no later product overflow. Where that would bring points so near to the origin
// that squares of their offsets vanish, because others are very far away, the extent is larger instead; points that
// are then beyond kFarthest are moved to it, axis by axis (docs/numerics.md).
//
// Leaf i holds points [i * kLeafSize, (i + 1) * kLeafSize) of the tree order; the last leaf is padded with points at
// infinity with id kPaddingId. The tree has no links: a node over n leaves has its left child, over LeftLeaves(n)
// leaves, right after it, and its right child after all of those.
//
// Positions are immutable once built (core/index/index_builder.h). Normals may be made, or turned, by phases that run
// before all that read them (core/normals/). Const methods are thread-safe; distinct leaves' normals may be written
// concurrently.
class SpatialIndex {
 public:
  static constexpr int kLeafSize = kLeafRecords;
  // Leaves whose points are estimated together; group g holds leaves [g * kGroupLeaves, (g + 1) * kGroupLeaves), which
  // lie below one node.
  static constexpr size_t kGroupLeaves = 4;
  static constexpr size_t kGroupPoints = kGroupLeaves * kLeafSize;
  // The largest coordinate where the scale does not come from the extent: squared distances, times what searches
  // multiply them by, stay finite.
  static constexpr float kFarthest = 0x1p50f;
  static constexpr int32_t kPaddingId = std::numeric_limits<int32_t>::max();

  // One leaf's points, coordinate by coordinate.
  struct alignas(64) LeafPositions {
    float x[kLeafSize];
    float y[kLeafSize];
    float z[kLeafSize];
    int32_t id[kLeafSize];  // rank: the place of the point in the cloud
  };
  struct alignas(64) LeafNormals {
    float x[kLeafSize];
    float y[kLeafSize];
    float z[kLeafSize];
  };

  static constexpr size_t LeafCount(size_t points) { return (points + kLeafSize - 1) / kLeafSize; }
  // At least half, and whole groups where there is more than one group.
  static constexpr size_t LeftLeaves(size_t leaves) {
    const size_t half = (leaves + 1) / 2;
    return leaves <= kGroupLeaves ? half : (half + kGroupLeaves - 1) / kGroupLeaves * kGroupLeaves;
  }
  static constexpr size_t RightChild(size_t node, size_t leaves) { return node + 2 * LeftLeaves(leaves); }

  // Valid points in the index.
  size_t point_count() const { return point_count_; }
  size_t leaf_count() const { return positions_.size(); }
  size_t group_count() const { return (leaf_count() + kGroupLeaves - 1) / kGroupLeaves; }
  // Points in leaf i that are not padding.
  int LeafPoints(size_t leaf) const {
    const size_t rest = point_count_ - leaf * kLeafSize;
    return rest < kLeafSize ? static_cast<int>(rest) : kLeafSize;
  }
  const LeafPositions& positions(size_t leaf) const { return positions_[leaf]; }
  // REQUIRES: has_normals().
  const LeafNormals& normals(size_t leaf) const { return normals_[leaf]; }
  // Makes room for normals, which have any values, in an index without. Errors: ErrorKind::kOutOfMemory.
  absl::Status MakeNormals() { return has_normals() ? absl::OkStatus() : MakeRoom(normals_); }
  LeafNormals& mutable_normals(size_t leaf) { return normals_[leaf]; }
  // Normals of which each was made of the points of its own half of the cloud alone (core/normals/runs/half_normals.h),
  // so that those of distinct halves err independently. REQUIRES: has_half_normals().
  const LeafNormals& half_normals(size_t leaf) const { return half_normals_[leaf]; }
  LeafNormals& mutable_half_normals(size_t leaf) { return half_normals_[leaf]; }
  bool has_half_normals() const { return half_normals_.size() > 0; }
  // Makes room for them, with any values. Errors: ErrorKind::kOutOfMemory. REQUIRES: point_count() > 0.
  absl::Status MakeHalfNormals() { return MakeRoom(half_normals_); }
  void DropHalfNormals() { half_normals_ = {}; }
  // Makes the normals of what was written in the place of half normals, which there are none of then. Those that came
  // with the cloud are kept, if they are to be.
  void TakeHalfNormals() {
    if (keeps_given_normals_ && given_normals_.size() == 0) given_normals_ = std::move(normals_);
    normals_ = std::move(half_normals_);
    DropHalfNormals();
  }
  // Whether positions showed edges of the surface when normals were made of them (NormalFit::edge_part). DEFAULT:
  // false.
  bool shows_edges() const { return shows_edges_; }
  void set_shows_edges(bool shows) { shows_edges_ = shows; }
  // Asks for the normals that came with the cloud to be kept, whatever becomes of them. Who changes them in their place
  // makes room before, and copies them there.
  void set_keeps_given_normals() { keeps_given_normals_ = true; }
  bool keeps_given_normals() const { return keeps_given_normals_; }
  // Errors: ErrorKind::kOutOfMemory. REQUIRES: point_count() > 0.
  absl::Status MakeGivenNormals() { return MakeRoom(given_normals_); }
  void KeepGivenNormals(size_t leaf) { given_normals_[leaf] = normals_[leaf]; }
  // As they came with the cloud, if they were kept or did not change. REQUIRES: has_normals().
  const LeafNormals& given_normals(size_t leaf) const {
    return given_normals_.size() > 0 ? given_normals_[leaf] : normals_[leaf];
  }
  // Whether there are points without a normal: theirs is NaN, and a sum of normals that holds it is worth nothing.
  bool lacks_normals() const { return lacks_normals_; }
  void set_lacks_normals() { lacks_normals_ = true; }
  bool has_normals() const { return normals_.size() > 0 || point_count_ == 0; }
  // Roles, ids and slots of the points, by their rank: the id beside their position.
  const PointSet& point_set() const { return point_set_; }
  // Node 0 is the root, over all leaves.
  const TreeNode& node(size_t i) const { return nodes_[i]; }
  // The bounds of all leaves' boxes on an axis, for whole vectors: kLeafSize values follow the last one.
  const float* leaf_lo(int axis) const { return &leaf_bounds_[axis * bounds_stride()]; }
  const float* leaf_hi(int axis) const { return &leaf_bounds_[(3 + axis) * bounds_stride()]; }
  // Multiplies a coordinate of the cloud into the index; its inverse takes lengths back.
  int scale_exponent() const { return scale_exponent_; }
  // Of the lattice that all positions are on (core/cloud/lattice.h), in the index's unit; 0: they are on none.
  float lattice_spacing() const { return lattice_spacing_; }
  size_t bytes() const {
    return positions_.bytes() + normals_.bytes() + half_normals_.bytes() + given_normals_.bytes() +
           leaf_bounds_.bytes() + nodes_.bytes() + point_set_.bytes();
  }

 private:
  friend class IndexBuilder;

  size_t bounds_stride() const { return leaf_count() + kLeafSize; }
  absl::Status MakeRoom(PageArray<LeafNormals>& normals) {
    auto made = PageArray<LeafNormals>::Create(leaf_count());
    if (!made.ok()) return made.status();
    normals = *std::move(made);
    normals[leaf_count() - 1] = LeafNormals{};  // padding
    return absl::OkStatus();
  }

  size_t point_count_ = 0;
  int scale_exponent_ = 0;
  float lattice_spacing_ = 0.0f;
  bool lacks_normals_ = false, keeps_given_normals_ = false;
  PageArray<LeafPositions> positions_;
  PageArray<LeafNormals> normals_;  // empty for a cloud without normals
  PageArray<LeafNormals> half_normals_, given_normals_;
  bool shows_edges_ = false;
  PointSet point_set_;
  PageArray<float> leaf_bounds_;  // lo of each axis, then hi
  PageArray<TreeNode> nodes_;
};

// Squared distance from a point to a box; 0 inside. Rounded like the kernels' distances, hence never larger than the
// computed squared distance to any point of the box.
inline float SquaredDistance(const float* point, const Box& box) {
  float squared[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float below = box.lo[axis] - point[axis];
    const float above = point[axis] - box.hi[axis];
    const float outside = below > above ? below : above;
    const float distance = outside > 0.0f ? outside : 0.0f;
    squared[axis] = distance * distance;
  }
  return (squared[0] + squared[1]) + squared[2];
}

}  // namespace curvd
