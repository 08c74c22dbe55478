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
  alignas(64) int32_t leaf[kSize];  // where that point is
  uint32_t used;                    // lanes of points that are estimated, as bits
  uint32_t tied;                    // lanes where two leaves were equally near at some time
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
  narrowed.Clear();
  narrowed.Reserve(leaves.size());
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const FloatMask near = NearBox(leaves, i, box, squared_reach);
    if (hn::AllFalse(d, near)) continue;
    const float* const lo[3] = {leaves.lo(0) + i, leaves.lo(1) + i, leaves.lo(2) + i};
    const float* const hi[3] = {leaves.hi(0) + i, leaves.hi(1) + i, leaves.hi(2) + i};
    AppendLeaves(lo, hi, hn::LoadU(IntTag(), reinterpret_cast<const int32_t*>(leaves.leaves() + i)), near, narrowed);
  }
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

// Smallest of the squared distances from the points of a leaf to each of the targets (tx, ty, tz).
HWY_INLINE FloatVec NearestInLeaf(const SpatialIndex::LeafPositions& points, FloatVec tx, FloatVec ty, FloatVec tz) {
  const FloatTag d;
  FloatVec nearest = hn::Set(d, std::numeric_limits<float>::infinity());
  for (int i = 0; i < SpatialIndex::kLeafSize; ++i) {
    const FloatVec squared = SquaredNorm(hn::Sub(hn::Set(d, points.x[i]), tx), hn::Sub(hn::Set(d, points.y[i]), ty),
                                         hn::Sub(hn::Set(d, points.z[i]), tz));
    nearest = hn::Min(nearest, squared);
  }
  return nearest;
}

// Searches the leaves for the one that holds the point nearest to each target of the patch. Returns the largest of the
// squared distances of the used targets; infinity if the leaves hold no point.
HWY_INLINE float SearchPatch(const SpatialIndex& index, const uint32_t* near, size_t near_count, TargetPatch& patch) {
  const FloatTag d;
  const IntTag di;
  FloatVec farthest = hn::Zero(d);
  uint64_t tied_lanes = 0;
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    const FloatVec tx = hn::Load(d, patch.x + lane), ty = hn::Load(d, patch.y + lane), tz = hn::Load(d, patch.z + lane);
    FloatVec best = hn::Set(d, std::numeric_limits<float>::infinity());
    auto best_leaf = hn::Zero(di);
    FloatMask tied = hn::FirstN(d, 0);
    for (size_t j = 0; j < near_count; ++j) {
      const FloatVec nearest = NearestInLeaf(index.positions(near[j]), tx, ty, tz);
      const auto leaf = hn::Set(di, static_cast<int32_t>(near[j]));
      tied = hn::Or(tied, hn::Eq(nearest, best));
      best_leaf = hn::IfThenElse(hn::RebindMask(di, hn::Lt(nearest, best)), leaf, best_leaf);
      best = hn::Min(best, nearest);
    }
    hn::Store(best, d, patch.squared_distance + lane);
    hn::Store(best_leaf, di, patch.leaf + lane);
    tied_lanes |= BitsFromMask(tied) << lane;
    farthest = hn::Max(farthest, hn::IfThenElseZero(MaskFromBits(patch.used >> lane), best));
  }
  patch.tied = static_cast<uint32_t>(tied_lanes);
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// Of the points of a leaf that are as near to the target of a lane as the nearest, the one with the lowest id; a
// negative number if there is none.
HWY_INLINE int NearestPoint(const SpatialIndex::LeafPositions& points, const TargetPatch& patch, size_t lane) {
  const FloatTag d;
  const FloatVec tx = hn::Set(d, patch.x[lane]), ty = hn::Set(d, patch.y[lane]), tz = hn::Set(d, patch.z[lane]);
  const FloatVec nearest = hn::Set(d, patch.squared_distance[lane]);
  uint64_t bits = 0;
  for (size_t i = 0; i < SpatialIndex::kLeafSize; i += hn::Lanes(d)) {
    const FloatVec squared = SquaredNorm(hn::Sub(hn::Load(d, points.x + i), tx), hn::Sub(hn::Load(d, points.y + i), ty),
                                         hn::Sub(hn::Load(d, points.z + i), tz));
    bits |= BitsFromMask(hn::Eq(squared, nearest)) << i;
  }
  int lowest = bits == 0 ? -1 : std::countr_zero(bits);
  for (bits &= bits - 1; HWY_UNLIKELY(bits != 0); bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (points.id[i] < points.id[lowest]) lowest = i;
  }
  return lowest;
}

// A point by its place in the index.
struct IndexedPoint {
  uint32_t leaf;
  int place;
};

// Of the points of the leaves that are as near to the target of a lane as the nearest, the one with the lowest id.
HWY_NOINLINE inline IndexedPoint LowestOfTied(const SpatialIndex& index, const uint32_t* near, size_t near_count,
                                              const TargetPatch& patch, size_t lane) {
  int32_t lowest_id = SpatialIndex::kPaddingId;
  IndexedPoint lowest{};
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(near[j]);
    const int place = NearestPoint(points, patch, lane);
    if (place < 0 || points.id[place] >= lowest_id) continue;
    lowest_id = points.id[place];
    lowest = {near[j], place};
  }
  return lowest;
}

// Leaves around the targets of several patches.
struct TargetLeaves {
  const LeafList* leaves;
  float squared_reach;  // all within this of any target are listed; negative: none are
};

HWY_INLINE void SetCorner(const SpatialIndex& index, IndexedPoint point, size_t i, int s, GroupScratch::Buffers& b) {
  const SpatialIndex::LeafPositions& points = index.positions(point.leaf);
  const SpatialIndex::LeafNormals& normals = index.normals(point.leaf);
  const int k = point.place;
  Hexagram& hexagram = b.hexagrams[0];
  const float offset[4] = {points.x[k] - b.query.x[i], points.y[k] - b.query.y[i], points.z[k] - b.query.z[i], 1.0f};
  const float normal[4] = {normals.x[k] - b.normal.x[i], normals.y[k] - b.normal.y[i], normals.z[k] - b.normal.z[i],
                           0.0f};
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
      if (b_.status[i] == PointStatus::kOk) squared_spacing_ = std::max(squared_spacing_, b_.squared_spacing[i]);
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

  // How far around the targets of corner s to look: as far as nearly all of the last ones had to.
  float SquaredGuess(int s) const { return squared_spacing_ * b_.target_reach[s]; }

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
    // Steps that settle where one guess in 33 is too low: a second search costs more than some leaves that hold
    // nothing, and beyond the rim of a surface, where targets are far from every point, no guess is worth keeping.
    constexpr float kAfterHit = 0.997f, kAfterMiss = 1.1f, kLeast = 0.5f, kMost = 1e6f;
    for (size_t p = 0; p < patch_count(); ++p) {
      if (patches_[s][p].used == 0) continue;
      const float step = FindPatchCorners(s, p, leaves) ? kAfterHit : kAfterMiss;
      b_.target_reach[s] = std::clamp(b_.target_reach[s] * step, kLeast, kMost);
    }
  }

  // Sets the corners to the points nearest to the targets of a patch. Returns whether all were as near as guessed.
  HWY_INLINE bool FindPatchCorners(int s, size_t p, const TargetLeaves& listed) {
    TargetPatch& patch = patches_[s][p];
    const float squared_reach = std::min(SquaredGuess(s), listed.squared_reach);
    size_t near_count = squared_reach < 0.0f ? 0 : CullLeavesAround(*listed.leaves, patch, squared_reach, b_.near);
    float farthest = SearchPatch(index_, b_.near.data(), near_count, patch);
    const bool guessed = farthest <= squared_reach;
    if (HWY_UNLIKELY(!guessed)) {
      // Any point bounds the distance of the nearest one.
      const auto own_leaf = static_cast<uint32_t>(first_leaf_ + p);
      if (farthest == std::numeric_limits<float>::infinity()) farthest = SearchPatch(index_, &own_leaf, 1, patch);
      const LeafList* leaves = listed.leaves;
      if (farthest > listed.squared_reach) {
        GatherLeaves(index_, patch.box, farthest, index_.leaf_count(), b_.own_leaves);
        leaves = &b_.own_leaves;
      }
      near_count = CullLeavesAround(*leaves, patch, farthest, b_.near);
      SearchPatch(index_, b_.near.data(), near_count, patch);
    }
    for (uint32_t used = patch.used; used != 0; used &= used - 1) {
      const int lane = std::countr_zero(used);
      const auto leaf = static_cast<uint32_t>(patch.leaf[lane]);
      const IndexedPoint corner = HWY_UNLIKELY((patch.tied >> lane & 1) != 0)
                                      ? LowestOfTied(index_, b_.near.data(), near_count, patch, lane)
                                      : IndexedPoint{leaf, NearestPoint(index_.positions(leaf), patch, lane)};
      SetCorner(index_, corner, p * TargetPatch::kSize + lane, s, b_);
    }
    return guessed;
  }

  const SpatialIndex& index_;
  GroupScratch::Buffers& b_;
  const size_t first_leaf_;
  float squared_spacing_ = 0.0f;  // the largest of the group
  TargetPatch patches_[6][SpatialIndex::kGroupLeaves];
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_KERNELS_NEAREST_CORNERS_INL_H_
