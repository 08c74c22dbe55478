// The points of the cloud nearest to a patch of targets: to up to 16 that lie near each other.
//
// They are searched together: one target a lane, and each point of the leaves around goes to all lanes at once. No
// branch depends on a distance.
//
// Where leaves are shared by several patches, that scan compares |p|^2 - 2 p t, which takes three multiply-adds. It
// rounds unlike the squared distance that decides; so it only bounds that, and the few points within the bound are
// compared by it.

#if defined(CURVD_CORE_ESTIMATORS_HEXAGRAM_TARGET_PATCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_HEXAGRAM_TARGET_PATCH_INL_H_
#undef CURVD_CORE_ESTIMATORS_HEXAGRAM_TARGET_PATCH_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_HEXAGRAM_TARGET_PATCH_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "core/estimators/hexagram/corner_scratch.h"
#include "core/estimators/measures-inl.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Targets, those of one corner for the points of one leaf, and what was found nearest to them.
struct TargetPatch {
  static constexpr size_t kSize = SpatialIndex::kLeafSize;
  alignas(64) float x[kSize];
  alignas(64) float y[kSize];
  alignas(64) float z[kSize];
  alignas(64) float bound[kSize];       // squared distance within which the nearest point is, and hardly another
  alignas(64) int32_t position[kSize];  // in the list, of the leaf that holds that point, unless
  uint32_t tied;                        // has the lane's bit: then another leaf may hold it
  uint32_t used;                        // lanes of points that are estimated, as bits
  Box box;                              // of the used targets
};

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

// Leaves around the targets of several patches.
struct TargetLeaves {
  const LeafList* leaves;
  float squared_reach;           // all leaves within this of any target are listed; negative: none are
  const CenteredLeaf* centered;  // by position in the list; nullptr where that does not pay
  float center[3];
};

// Copies the points of the listed leaves relative to the center of a box, unless the leaves are many. Padding keeps a
// squared norm of infinity.
HWY_INLINE void CenterLeaves(const SpatialIndex& index, const Box& box, ScratchArray<CenteredLeaf>& centered,
                             TargetLeaves& listed) {
  const LeafList& leaves = *listed.leaves;
  listed.centered = nullptr;
  if (leaves.size() > CornerScratch::kMaxCentered) return;
  const FloatTag d;
  const FloatVec finite = hn::Set(d, 1e18f);
  for (int axis = 0; axis < 3; ++axis) listed.center[axis] = 0.5f * (box.lo[axis] + box.hi[axis]);
  const FloatVec cx = hn::Set(d, listed.center[0]), cy = hn::Set(d, listed.center[1]),
                 cz = hn::Set(d, listed.center[2]);
  centered.Reserve(CornerScratch::kMaxCentered);
  for (size_t j = 0; j < leaves.size(); ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(leaves.leaf(j));
    CenteredLeaf& leaf = centered[j];
    for (size_t i = 0; i < SpatialIndex::kLeafSize; i += hn::Lanes(d)) {
      const FloatVec x = hn::Sub(hn::Load(d, points.x + i), cx);
      const FloatVec y = hn::Sub(hn::Load(d, points.y + i), cy);
      const FloatVec z = hn::Sub(hn::Load(d, points.z + i), cz);
      hn::Store(hn::Min(x, finite), d, leaf.x + i);
      hn::Store(hn::Min(y, finite), d, leaf.y + i);
      hn::Store(hn::Min(z, finite), d, leaf.z + i);
      hn::Store(SquaredNorm(x, y, z), d, leaf.squared_norm + i);
    }
  }
  listed.centered = centered.data();
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

// Lists the positions of the leaves within the squared reach of a target; returns their number.
HWY_INLINE size_t CullLeavesAround(const LeafList& leaves, const TargetPatch& patch, float squared_reach,
                                   ScratchArray<uint32_t>& near) {
  const FloatTag d;
  const IntTag di;
  near.Reserve(leaves.padded_size() + LeafList::kPad);
  auto* positions = reinterpret_cast<int32_t*>(near.data());
  size_t count = 0;
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const auto meets = hn::RebindMask(di, NearBox(leaves, i, patch.box, squared_reach));
    hn::StoreU(hn::Compress(IntsFrom(static_cast<int32_t>(i)), meets), di, positions + count);
    count += hn::CountTrue(di, meets);
  }
  // Few leaves near the box of the targets are near none of them, unless the targets are far apart.
  constexpr size_t kFew = 12;
  if (HWY_LIKELY(count <= kFew)) return count;
  size_t kept = 0;
  for (size_t j = 0; j < count; ++j) {
    near[kept] = near[j];
    kept += NearTargets(leaves, near[j], patch, squared_reach) ? 1 : 0;
  }
  return kept;
}

// |p|^2 - 2 p t of point i of a leaf for the targets of a vector's lanes, given -2 t.
HWY_INLINE FloatVec SquaredDistanceLessNorm(const CenteredLeaf& points, int i, const Triple& doubled) {
  const FloatTag d;
  const FloatVec z = hn::MulAdd(hn::Set(d, points.z[i]), doubled.z, hn::Set(d, points.squared_norm[i]));
  const FloatVec yz = hn::MulAdd(hn::Set(d, points.y[i]), doubled.y, z);
  return hn::MulAdd(hn::Set(d, points.x[i]), doubled.x, yz);
}

// |p - t|^2, as it decides.
HWY_INLINE FloatVec SquaredDistance(const SpatialIndex::LeafPositions& points, int i, const Triple& targets) {
  const FloatTag d;
  return SquaredNorm(hn::Sub(hn::Set(d, points.x[i]), targets.x), hn::Sub(hn::Set(d, points.y[i]), targets.y),
                     hn::Sub(hn::Set(d, points.z[i]), targets.z));
}

// Smallest of a function of the points of a leaf, by their places in it.
template <typename Function>
HWY_INLINE FloatVec LeastInLeaf(Function f) {
  // Four chains, since each step waits for the one before it.
  FloatVec a = f(0), b = f(1), c = f(2), e = f(3);
  for (int i = 4; i < SpatialIndex::kLeafSize; i += 4) {
    a = hn::Min(a, f(i));
    b = hn::Min(b, f(i + 1));
    c = hn::Min(c, f(i + 2));
    e = hn::Min(e, f(i + 3));
  }
  return hn::Min(hn::Min(a, b), hn::Min(c, e));
}

// What is least for each lane's target among leaves.
struct LeastOfLeaves {
  FloatVec least;
  FloatVec second;           // of the other leaves' least
  hn::Vec<IntTag> position;  // of the leaf
};

// Finds it by `least_in_leaf(position)`.
template <typename LeastIn>
HWY_INLINE LeastOfLeaves FindLeast(const uint32_t* near, size_t near_count, LeastIn least_in_leaf) {
  const IntTag di;
  const FloatVec infinity = hn::Set(FloatTag(), std::numeric_limits<float>::infinity());
  LeastOfLeaves found{infinity, infinity, hn::Zero(di)};
  for (size_t j = 0; j < near_count; ++j) {
    const FloatVec in_leaf = least_in_leaf(near[j]);
    const auto position = hn::Set(di, static_cast<int32_t>(near[j]));
    found.position = hn::IfThenElse(hn::RebindMask(di, hn::Lt(in_leaf, found.least)), position, found.position);
    found.second = hn::Min(found.second, hn::Max(in_leaf, found.least));
    found.least = hn::Min(found.least, in_leaf);
  }
  return found;
}

// Records what was found for targets lane, lane + 1, ... of the patch: the bound, and that the leaf may be another one
// where the second is at most `tie`. Returns the largest bound of a used target.
HWY_INLINE float Record(const LeastOfLeaves& found, FloatVec bound, FloatVec tie, size_t lane, TargetPatch& patch) {
  const FloatTag d;
  hn::Store(bound, d, patch.bound + lane);
  hn::Store(found.position, IntTag(), patch.position + lane);
  patch.tied |= static_cast<uint32_t>(BitsFromMask(hn::Le(found.second, tie)) << lane);
  return hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(MaskFromBits(patch.used >> lane), bound)));
}

HWY_INLINE Triple LoadTargets(const TargetPatch& patch, size_t lane) {
  const FloatTag d;
  return {hn::Load(d, patch.x + lane), hn::Load(d, patch.y + lane), hn::Load(d, patch.z + lane)};
}

// Searches the listed leaves at the `near` positions, which are centered, for the one that holds the point nearest to
// each target. Returns a squared distance within which every used target has a point; infinity if there are no leaves.
HWY_INLINE float SearchCentered(const TargetLeaves& leaves, const uint32_t* near, size_t near_count,
                                TargetPatch& patch) {
  // Either way to compute a squared distance, some 60 operations err by at most 2^-24 of the larger squared norm each.
  // That is at most 4 |t|^2, or else at most four times the squared distance. Where numbers are tiny, errors are below
  // the smallest normal one.
  constexpr float kRelativeError = 0x1p-15f, kLeastError = std::numeric_limits<float>::min();
  const FloatTag d;
  const Triple center{hn::Set(d, leaves.center[0]), hn::Set(d, leaves.center[1]), hn::Set(d, leaves.center[2])};
  float farthest = 0.0f;
  patch.tied = 0;
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    const Triple targets = Sub(LoadTargets(patch, lane), center);
    const Triple doubled = Scale(targets, hn::Set(d, -2.0f));
    const LeastOfLeaves found = FindLeast(near, near_count, [&](uint32_t position) {
      const CenteredLeaf& points = leaves.centered[position];
      return LeastInLeaf([&](int i) { return SquaredDistanceLessNorm(points, i, doubled); });
    });
    const FloatVec norm = Dot(targets, targets);
    const FloatVec distance = hn::Add(found.least, norm);
    const FloatVec error = hn::MulAdd(hn::Add(distance, norm), hn::Set(d, kRelativeError), hn::Set(d, kLeastError));
    const FloatVec tie = hn::Add(found.least, hn::Add(error, error));
    farthest = std::max(farthest, Record(found, hn::Add(distance, error), tie, lane, patch));
  }
  return farthest;
}

// The same for leaves that are not centered, by the distances that decide: bounds hold the nearest point and its
// equals.
HWY_INLINE float SearchExactly(const SpatialIndex& index, const LeafList& leaves, const uint32_t* near,
                               size_t near_count, TargetPatch& patch) {
  float farthest = 0.0f;
  patch.tied = 0;
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(FloatTag())) {
    const Triple targets = LoadTargets(patch, lane);
    const LeastOfLeaves found = FindLeast(near, near_count, [&](uint32_t position) {
      const SpatialIndex::LeafPositions& points = index.positions(leaves.leaf(position));
      return LeastInLeaf([&](int i) { return SquaredDistance(points, i, targets); });
    });
    farthest = std::max(farthest, Record(found, found.least, found.least, lane, patch));
  }
  return farthest;
}

// The points of a leaf within the bound of a lane's target, as bits.
HWY_INLINE uint64_t PointsInBound(const SpatialIndex::LeafPositions& points, const TargetPatch& patch, size_t lane) {
  const FloatTag d;
  const FloatVec tx = hn::Set(d, patch.x[lane]), ty = hn::Set(d, patch.y[lane]), tz = hn::Set(d, patch.z[lane]);
  const FloatVec bound = hn::Set(d, patch.bound[lane]);
  uint64_t bits = 0;
  for (size_t i = 0; i < SpatialIndex::kLeafSize; i += hn::Lanes(d)) {
    const FloatVec squared = SquaredNorm(hn::Sub(hn::Load(d, points.x + i), tx), hn::Sub(hn::Load(d, points.y + i), ty),
                                         hn::Sub(hn::Load(d, points.z + i), tz));
    bits |= BitsFromMask(hn::Le(squared, bound)) << i;
  }
  return bits;
}

// A point by its place in the index, and its rank among those that might be nearest to a target.
struct IndexedPoint {
  uint32_t leaf = 0;
  int place = 0;
  NeighborRank rank{std::numeric_limits<float>::infinity(), SpatialIndex::kPaddingId};
};

// Of the points within the bound of a lane's target, the nearest, and of equally near ones that with the lowest id.
// `near`: positions of the leaves that may hold it.
HWY_NOINLINE inline IndexedPoint NearestInBound(const SpatialIndex& index, const LeafList& leaves, const uint32_t* near,
                                                size_t near_count, const TargetPatch& patch, size_t lane) {
  IndexedPoint nearest;
  for (size_t j = 0; j < near_count; ++j) {
    const uint32_t leaf = leaves.leaf(near[j]);
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (uint64_t bits = PointsInBound(points, patch, lane); bits != 0; bits &= bits - 1) {
      const int place = std::countr_zero(bits);
      const float x = points.x[place] - patch.x[lane], y = points.y[place] - patch.y[lane],
                  z = points.z[place] - patch.z[lane];
      const NeighborRank rank{x * x + y * y + z * z, points.id[place]};
      if (rank < nearest.rank) nearest = {leaf, place, rank};
    }
  }
  return nearest;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_TARGET_PATCH_INL_H_
