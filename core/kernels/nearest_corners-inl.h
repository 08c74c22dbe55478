// The hexagram's corners as the points of the cloud nearest to six targets in the tangent plane.
//
// The targets of one corner for the points of one leaf lie near each other, so they are searched together: one target a
// lane, and each point of the leaves around goes to all lanes at once. Nothing is reduced and no branch depends on a
// distance. How far around is a guess that decides on the time alone: what is found within it is exact, and what is not
// bounds a second search.

#if defined(CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_
#undef CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_
#else
#define CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "core/group_buffers.h"
#include "core/kernels/measures-inl.h"
#include "core/kernels/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The targets of one corner for the points of one leaf, and what is nearest to them so far.
struct TargetPatch {
  static constexpr size_t kSize = SpatialIndex::kLeafSize;
  alignas(64) float x[kSize];
  alignas(64) float y[kSize];
  alignas(64) float z[kSize];
  alignas(64) float squared_distance[kSize];
  alignas(64) int32_t slot[kSize];  // in tree order; -1: nothing found
  uint32_t used;                    // lanes of points that are estimated, as bits
  uint32_t tied;                    // lanes where two points were equally near at some time
  Box box;                          // of the used targets
};

// Sets the targets of corner s, at s * 60 degrees and distance rho, for points first, first + 1, ... of the group.
HWY_INLINE void SetTargets(const GroupScratch::Buffers& b, size_t first, int s, TargetPatch& patch) {
  constexpr float kCos[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  constexpr float kSin[6] = {0.0f, kSqrt3 / 2, kSqrt3 / 2, 0.0f, -kSqrt3 / 2, -kSqrt3 / 2};
  const FloatTag d;
  const FloatVec infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  FloatVec lo[3] = {infinity, infinity, infinity};
  FloatVec hi[3] = {hn::Neg(infinity), hn::Neg(infinity), hn::Neg(infinity)};
  patch.used = 0;
  const size_t size = std::min(TargetPatch::kSize, b.size - first);
  for (size_t lane = 0; lane < size; ++lane) {
    if (b.status[first + lane] == PointStatus::kOk) patch.used |= 1u << lane;
  }
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    const size_t i = first + lane;
    const FloatVec rho = hn::Load(d, b.rho + i);
    const FloatVec along_u = hn::Mul(rho, hn::Set(d, kCos[s])), along_v = hn::Mul(rho, hn::Set(d, kSin[s]));
    const Triple offset = Add(Scale(LoadTriple(b.u, i), along_u), Scale(LoadTriple(b.v, i), along_v));
    const Triple target = Add(LoadTriple(b.query, i), offset);
    hn::Store(target.x, d, patch.x + lane);
    hn::Store(target.y, d, patch.y + lane);
    hn::Store(target.z, d, patch.z + lane);
    const FloatMask used = MaskFromBits(patch.used >> lane);
    const FloatVec coordinates[3] = {target.x, target.y, target.z};
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = hn::Min(lo[axis], hn::IfThenElse(used, coordinates[axis], infinity));
      hi[axis] = hn::Max(hi[axis], hn::IfThenElse(used, coordinates[axis], hn::Neg(infinity)));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    patch.box.lo[axis] = hn::GetLane(hn::MinOfLanes(d, lo[axis]));
    patch.box.hi[axis] = hn::GetLane(hn::MaxOfLanes(d, hi[axis]));
  }
}

// Which of the leaves i, i + 1, ... of a list lie within the squared reach of a box.
HWY_INLINE FloatMask NearBox(const LeafList& leaves, size_t i, const Box& box, float squared_reach) {
  const FloatTag d;
  FloatVec gap[3];
  for (int axis = 0; axis < 3; ++axis) {
    const FloatVec below = hn::Sub(hn::Load(d, leaves.lo(axis) + i), hn::Set(d, box.hi[axis]));
    const FloatVec above = hn::Sub(hn::Set(d, box.lo[axis]), hn::Load(d, leaves.hi(axis) + i));
    gap[axis] = hn::Max(hn::Max(below, above), hn::Zero(d));
  }
  return hn::Le(SquaredNorm(gap[0], gap[1], gap[2]), hn::Set(d, squared_reach));
}

// Copies the leaves within the squared reach of a box from one list to another.
HWY_INLINE void NarrowLeaves(const LeafList& leaves, const Box& box, float squared_reach, LeafList& narrowed) {
  const FloatTag d;
  const IntTag di;
  narrowed.Reserve(leaves.padded_size());
  size_t size = 0;
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const FloatMask near = NearBox(leaves, i, box, squared_reach);
    const size_t count = hn::CountTrue(d, near);
    if (count == 0) continue;
    const auto ids = hn::LoadU(di, reinterpret_cast<const int32_t*>(leaves.leaves() + i));
    hn::StoreU(hn::Compress(ids, hn::RebindMask(di, near)), di,
               reinterpret_cast<int32_t*>(narrowed.mutable_leaves() + size));
    for (int axis = 0; axis < 3; ++axis) {
      hn::StoreU(hn::Compress(hn::Load(d, leaves.lo(axis) + i), near), d, narrowed.mutable_bound(axis) + size);
      hn::StoreU(hn::Compress(hn::Load(d, leaves.hi(axis) + i), near), d, narrowed.mutable_bound(3 + axis) + size);
    }
    size += count;
  }
  narrowed.set_size(size);
  narrowed.Pad();
}

// Whether a leaf lies within the squared reach of any target that is used.
HWY_INLINE bool NearTargets(const LeafList& leaves, size_t i, const TargetPatch& patch, float squared_reach) {
  const FloatTag d;
  const float* targets[3] = {patch.x, patch.y, patch.z};
  uint64_t near = 0;
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    FloatVec gap[3];
    for (int axis = 0; axis < 3; ++axis) {
      gap[axis] = DistanceOutside(hn::Load(d, targets[axis] + lane), hn::Set(d, leaves.lo(axis)[i]),
                                  hn::Set(d, leaves.hi(axis)[i]));
    }
    near |= BitsFromMask(hn::Le(SquaredNorm(gap[0], gap[1], gap[2]), hn::Set(d, squared_reach))) << lane;
  }
  return (near & patch.used) != 0;
}

// Lists the leaves within the squared reach of a target; returns their number.
HWY_INLINE size_t CullLeavesAround(const LeafList& leaves, const TargetPatch& patch, float squared_reach,
                                   ScratchArray<uint32_t>& near) {
  near.Reserve(leaves.padded_size());
  size_t count = 0;
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(FloatTag())) {
    uint64_t meets = BitsFromMask(NearBox(leaves, i, patch.box, squared_reach));
    for (; meets != 0; meets &= meets - 1) {
      const size_t position = i + std::countr_zero(meets);
      near[count] = leaves.leaf(position);
      count += NearTargets(leaves, position, patch, squared_reach) ? 1 : 0;
    }
  }
  return count;
}

// Searches the leaves for the point nearest to each target of the patch. Returns the largest of the squared distances
// of the used targets; infinity if the leaves hold no point.
HWY_INLINE float SearchPatch(const SpatialIndex& index, const uint32_t* near, size_t near_count, TargetPatch& patch) {
  const FloatTag d;
  const IntTag di;
  constexpr int kLeaf = SpatialIndex::kLeafSize;
  FloatVec farthest = hn::Zero(d);
  uint64_t tied_lanes = 0;
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    const FloatVec tx = hn::Load(d, patch.x + lane), ty = hn::Load(d, patch.y + lane), tz = hn::Load(d, patch.z + lane);
    FloatVec best = hn::Set(d, std::numeric_limits<float>::infinity());
    auto best_slot = hn::Set(di, -1);
    FloatMask tied = hn::FirstN(d, 0);
    for (size_t j = 0; j < near_count; ++j) {
      const SpatialIndex::LeafPositions& points = index.positions(near[j]);
      auto slot = hn::Set(di, static_cast<int32_t>(near[j]) * kLeaf);
      for (int i = 0; i < kLeaf; ++i) {
        const FloatVec squared = SquaredNorm(hn::Sub(hn::Set(d, points.x[i]), tx), hn::Sub(hn::Set(d, points.y[i]), ty),
                                             hn::Sub(hn::Set(d, points.z[i]), tz));
        tied = hn::Or(tied, hn::Eq(squared, best));
        best_slot = hn::IfThenElse(hn::RebindMask(di, hn::Lt(squared, best)), slot, best_slot);
        best = hn::Min(squared, best);
        slot = hn::Add(slot, hn::Set(di, 1));
      }
    }
    hn::Store(best, d, patch.squared_distance + lane);
    hn::Store(best_slot, di, patch.slot + lane);
    tied_lanes |= BitsFromMask(tied) << lane;
    farthest = hn::Max(farthest, hn::IfThenElseZero(MaskFromBits(patch.used >> lane), best));
  }
  patch.tied = static_cast<uint32_t>(tied_lanes);
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// Of the points of the leaves that are as near to the target of a lane as the nearest, the slot with the lowest id.
HWY_NOINLINE inline int32_t LowestTiedSlot(const SpatialIndex& index, const uint32_t* near, size_t near_count,
                                           const TargetPatch& patch, size_t lane) {
  int32_t lowest_id = SpatialIndex::kPaddingId;
  int32_t slot = patch.slot[lane];
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(near[j]);
    for (int i = 0; i < SpatialIndex::kLeafSize; ++i) {
      const float dx = points.x[i] - patch.x[lane], dy = points.y[i] - patch.y[lane], dz = points.z[i] - patch.z[lane];
      if ((dx * dx + dy * dy) + dz * dz != patch.squared_distance[lane] || points.id[i] >= lowest_id) continue;
      lowest_id = points.id[i];
      slot = static_cast<int32_t>(near[j]) * SpatialIndex::kLeafSize + i;
    }
  }
  return slot;
}

// Leaves around the targets of several patches.
struct TargetLeaves {
  const LeafList* leaves;
  float squared_reach;  // all within this of any target are listed; negative: none are
};

// Finds the points nearest to the targets of a patch around points of leaf `own_leaf`.
HWY_INLINE void FindPatchCorners(const SpatialIndex& index, const TargetLeaves& listed, float squared_guess,
                                 uint32_t own_leaf, TargetPatch& patch, GroupScratch::Buffers& b) {
  float squared_reach = std::min(squared_guess, listed.squared_reach);
  size_t near_count = squared_reach < 0.0f ? 0 : CullLeavesAround(*listed.leaves, patch, squared_reach, b.near);
  float farthest = SearchPatch(index, b.near.data(), near_count, patch);
  if (HWY_UNLIKELY(farthest > squared_reach)) {
    // Any point bounds the distance of the nearest one.
    if (farthest == std::numeric_limits<float>::infinity()) farthest = SearchPatch(index, &own_leaf, 1, patch);
    const LeafList* leaves = listed.leaves;
    if (farthest > listed.squared_reach) {
      GatherLeaves(index, patch.box, farthest, index.leaf_count(), b.own_leaves);
      leaves = &b.own_leaves;
    }
    near_count = CullLeavesAround(*leaves, patch, farthest, b.near);
    SearchPatch(index, b.near.data(), near_count, patch);
  }
  for (uint32_t tied = patch.tied & patch.used; tied != 0; tied &= tied - 1) {
    const int lane = std::countr_zero(tied);
    patch.slot[lane] = LowestTiedSlot(index, b.near.data(), near_count, patch, lane);
  }
}

HWY_INLINE void SetCorner(const SpatialIndex& index, int32_t slot, size_t i, int s, GroupScratch::Buffers& b) {
  const SpatialIndex::LeafPositions& points = index.positions(slot / SpatialIndex::kLeafSize);
  const SpatialIndex::LeafNormals& normals = index.normals(slot / SpatialIndex::kLeafSize);
  const int lane = slot % SpatialIndex::kLeafSize;
  Hexagram& hexagram = b.hexagrams[0];
  const float offset[4] = {points.x[lane] - b.query.x[i], points.y[lane] - b.query.y[i], points.z[lane] - b.query.z[i],
                           1.0f};
  const float normal[4] = {normals.x[lane] - b.normal.x[i], normals.y[lane] - b.normal.y[i],
                           normals.z[lane] - b.normal.z[i], 0.0f};
  std::copy(offset, offset + 4, hexagram.offset[s][i]);
  std::copy(normal, normal + 4, hexagram.normal[s][i]);
}

// Sets each point's corners to the points of the cloud nearest to its six targets.
class CornerSearch {
 public:
  CornerSearch(const SpatialIndex& index, size_t group, GroupScratch::Buffers& b)
      : index_(index), b_(b), first_leaf_(group * SpatialIndex::kGroupLeaves) {}

  HWY_NOINLINE void SetCorners() {
    for (size_t i = 0; i < b_.size; ++i) {
      if (b_.status[i] == PointStatus::kOk) reach_ = std::max(reach_, b_.nearest_reach[i]);
    }
    for (int s = 0; s < 6; ++s) {
      for (size_t p = 0; p < patch_count(); ++p) SetTargets(b_, p * TargetPatch::kSize, s, patches_[s][p]);
    }
    // One descent of the tree serves all corners, or where the figure is large against the group, one each.
    constexpr size_t kMaxShared = 256, kMaxSingle = 512;
    const bool shared = Gather(0, 6, kMaxShared);
    for (int s = 0; s < 6; ++s) {
      if (shared) {
        NarrowLeaves(b_.leaves, PatchesBox(s, s + 1), SquaredReach(s, s + 1), b_.corner_leaves);
        FindCorners(s, {&b_.corner_leaves, SquaredReach(s, s + 1)});
      } else {
        const bool listed = Gather(s, s + 1, kMaxSingle);
        FindCorners(s, {&b_.leaves, listed ? SquaredReach(s, s + 1) : -1.0f});
      }
    }
  }

 private:
  size_t patch_count() const { return (b_.size + TargetPatch::kSize - 1) / TargetPatch::kSize; }

  // How far around the targets of corner s to look: the height of the last ones over the surface tells that of the
  // next.
  float SquaredGuess(int s) const { return reach_ * reach_ + b_.squared_target_height[s]; }

  // How far around the targets of corners [first, last) to list leaves: farther than any patch is expected to look.
  float SquaredReach(int first, int last) const {
    constexpr float kSpare = 2.0f;
    float squared = 0.0f;
    for (int s = first; s < last; ++s) squared = std::max(squared, SquaredGuess(s) * kSpare);
    return squared;
  }

  Box PatchesBox(int first, int last) const {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (int s = first; s < last; ++s) {
      for (size_t p = 0; p < patch_count(); ++p) {
        for (int axis = 0; axis < 3; ++axis) {
          box.lo[axis] = std::min(box.lo[axis], patches_[s][p].box.lo[axis]);
          box.hi[axis] = std::max(box.hi[axis], patches_[s][p].box.hi[axis]);
        }
      }
    }
    return box;
  }

  // Lists the leaves around the targets of corners [first, last). Returns false if they are too many.
  bool Gather(int first, int last, size_t max_leaves) {
    return GatherLeaves(index_, PatchesBox(first, last), SquaredReach(first, last), max_leaves, b_.leaves);
  }

  HWY_INLINE void FindCorners(int s, const TargetLeaves& leaves) {
    for (size_t p = 0; p < patch_count(); ++p) {
      TargetPatch& patch = patches_[s][p];
      if (patch.used == 0) continue;
      FindPatchCorners(index_, leaves, SquaredGuess(s), static_cast<uint32_t>(first_leaf_ + p), patch, b_);
      float height = std::numeric_limits<float>::infinity();
      for (uint32_t used = patch.used; used != 0; used &= used - 1) {
        const int lane = std::countr_zero(used);
        SetCorner(index_, patch.slot[lane], p * TargetPatch::kSize + lane, s, b_);
        height = std::min(height, patch.squared_distance[lane]);
      }
      b_.squared_target_height[s] = height;
    }
  }

  const SpatialIndex& index_;
  GroupScratch::Buffers& b_;
  const size_t first_leaf_;
  float reach_ = 0.0f;
  TargetPatch patches_[6][SpatialIndex::kGroupLeaves];
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_
