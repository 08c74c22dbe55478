// The hexagram's corners as the points of the cloud nearest to six targets in the tangent plane.
//
// The targets of one corner for the points of one leaf lie near each other, so they are searched together
// (core/estimators/hexagram/target_patch-inl.h). How far around is a guess that decides on the time alone: what is
// found within it is exact, and what is not bounds a second search.

#if defined(CURVD_CORE_ESTIMATORS_HEXAGRAM_NEAREST_CORNERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_HEXAGRAM_NEAREST_CORNERS_INL_H_
#undef CURVD_CORE_ESTIMATORS_HEXAGRAM_NEAREST_CORNERS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_HEXAGRAM_NEAREST_CORNERS_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "core/estimators/hexagram/hexagram_scratch.h"
#include "core/estimators/hexagram/target_patch-inl.h"
#include "core/estimators/measures-inl.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The nearest multiples of a power of two that is not far smaller; for 0, the same vectors.
HWY_INLINE Triple RoundedTo(float spacing, const Triple& v) {
  const FloatVec magic = hn::Set(FloatTag(), 0x1.8p23f * spacing);
  const auto round = [&](FloatVec x) HWY_ATTR { return hn::Sub(hn::Add(x, magic), magic); };
  return {round(v.x), round(v.y), round(v.z)};
}

// Sets the targets of corner s, at s * 60 degrees and distance rho, for points first, first + 1, ... of the group. Where
// points are on a lattice, so are the targets: sums are then exact, and the same wherever its origin is.
HWY_INLINE void SetTargets(const GroupPoints& points, const GroupFrames& frames, float lattice_spacing, size_t first,
                           int s, TargetPatch& patch) {
  constexpr float kCos[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  constexpr float kSin[6] = {0.0f, kSqrt3 / 2, kSqrt3 / 2, 0.0f, -kSqrt3 / 2, -kSqrt3 / 2};
  const FloatTag d;
  const FloatVec infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  FloatVec lo[3] = {infinity, infinity, infinity};
  FloatVec hi[3] = {hn::Neg(infinity), hn::Neg(infinity), hn::Neg(infinity)};
  patch.used = 0;
  const size_t size = std::min(TargetPatch::kSize, points.size - first);
  for (size_t lane = 0; lane < size; ++lane) {
    if (points.status[first + lane] == PointStatus::kOk) patch.used |= 1u << lane;
  }
  for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
    const size_t i = first + lane;
    const FloatVec rho = hn::Load(d, frames.rho + i);
    const FloatVec along_u = hn::Mul(rho, hn::Set(d, kCos[s])), along_v = hn::Mul(rho, hn::Set(d, kSin[s]));
    const Triple offset = Add(Scale(LoadTriple(frames.u, i), along_u), Scale(LoadTriple(frames.v, i), along_v));
    const Triple target = Add(LoadTriple(points.query, i), RoundedTo(lattice_spacing, offset));
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

HWY_INLINE void SetCorner(const SpatialIndex& index, const IndexedPoint& point, const GroupPoints& group, size_t i,
                          int s, Hexagram& hexagram) {
  const SpatialIndex::LeafPositions& points = index.positions(point.leaf);
  const SpatialIndex::LeafNormals& normals = index.normals(point.leaf);
  const int k = point.place;
  const float offset[4] = {points.x[k] - group.query.x[i], points.y[k] - group.query.y[i],
                           points.z[k] - group.query.z[i], 1.0f};
  const float normal[4] = {normals.x[k] - group.normal.x[i], normals.y[k] - group.normal.y[i],
                           normals.z[k] - group.normal.z[i], 0.0f};
  std::copy(offset, offset + 4, hexagram.offset[s][i]);
  std::copy(normal, normal + 4, hexagram.normal[s][i]);
}

// Sets each point's corners to the points of the cloud nearest to its six targets.
class CornerSearch {
 public:
  // `points` and `frames` are those of a group. Sets `hexagram` for the points whose status is OK. What `search` has
  // found is lost.
  CornerSearch(const SpatialIndex& index, const GroupPoints& points, const GroupFrames& frames, SearchScratch& search,
               CornerScratch& scratch, Hexagram& hexagram)
      : index_(index), points_(points), frames_(frames), search_(search), scratch_(scratch), hexagram_(hexagram) {}

  // Ends early, with some corners unset, once the search is stopped.
  HWY_NOINLINE void SetCorners() {
    for (size_t i = 0; i < points_.size; ++i) {
      if (points_.status[i] == PointStatus::kOk)
        squared_spacing_ = std::max(squared_spacing_, frames_.squared_spacing[i]);
    }
    for (int s = 0; s < 6; ++s) {
      for (size_t p = 0; p < patch_count(); ++p)
        SetTargets(points_, frames_, index_.lattice_spacing(), p * TargetPatch::kSize, s, patches_[s][p]);
    }
    // One descent of the tree serves all corners, or where the figure is large against the group, one each.
    const bool shared = Gather(0, 6, CornerScratch::kMaxShared);
    for (int s = 0; s < 6 && !search_.IsStopped(); ++s) {
      const Box box = PatchesBox(s, s + 1);
      TargetLeaves listed{shared ? &scratch_.corner_leaves : &scratch_.leaves, SquaredReach(s, s + 1), nullptr, {}};
      if (shared) {
        NarrowLeaves(scratch_.leaves, box, listed.squared_reach, scratch_.corner_leaves);
        search_.work += scratch_.leaves.size();
      } else if (!Gather(s, s + 1, CornerScratch::kMaxSingle)) {
        scratch_.leaves.Clear();
        listed.squared_reach = -1.0f;
      }
      CenterLeaves(index_, box, scratch_.centered, listed);
      FindCorners(s, listed);
    }
  }

 private:
  size_t patch_count() const { return (points_.size + TargetPatch::kSize - 1) / TargetPatch::kSize; }

  // How far around the targets of corner s to look: as far as nearly all of the last ones had to.
  float SquaredGuess(int s) const { return squared_spacing_ * scratch_.target_reach[s]; }

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
    return GatherLeaves(index_, PatchesBox(first, last), SquaredReach(first, last), max_leaves, scratch_.leaves,
                        search_.work);
  }

  HWY_INLINE void FindCorners(int s, const TargetLeaves& leaves) {
    // Steps that settle where one guess in 33 is too low: a second search costs more than some leaves that hold
    // nothing, and beyond the rim of a surface, where targets are far from every point, no guess is worth keeping.
    constexpr float kAfterHit = 0.997f, kAfterMiss = 1.1f, kLeast = 0.5f, kMost = 1e6f;
    for (size_t p = 0; p < patch_count(); ++p) {
      if (patches_[s][p].used == 0) continue;
      const float step = FindPatchCorners(s, p, leaves) ? kAfterHit : kAfterMiss;
      scratch_.target_reach[s] = std::clamp(scratch_.target_reach[s] * step, kLeast, kMost);
    }
  }

  // Sets the corners to the points nearest to the targets of a patch. Returns whether all were as near as guessed.
  HWY_INLINE bool FindPatchCorners(int s, size_t p, const TargetLeaves& listed) {
    TargetPatch& patch = patches_[s][p];
    const float squared_reach = std::min(SquaredGuess(s), listed.squared_reach);
    const float bound = Search(listed, squared_reach, patch);
    // The bounds of targets far from the center may hold many points.
    constexpr int kManyTied = 4;
    const bool guessed = bound <= squared_reach;
    if (HWY_LIKELY(guessed && std::popcount(patch.tied & patch.used) < kManyTied)) {
      TakeNearest(s, p, *listed.leaves);
    } else {
      SearchAgain(s, p, listed, std::min(bound, OwnBound(p, patch)));
    }
    return guessed;
  }

  // Searches the listed leaves within the squared reach of a target.
  HWY_INLINE float Search(const TargetLeaves& listed, float squared_reach, TargetPatch& patch) {
    near_count_ = CullLeavesAround(*listed.leaves, patch, squared_reach, scratch_.near);
    // Every point of these leaves meets every target.
    search_.work += listed.leaves->size() + near_count_ * SpatialIndex::kLeafSize * TargetPatch::kSize;
    if (listed.centered != nullptr) return SearchCentered(listed, scratch_.near.data(), near_count_, patch);
    return SearchExactly(index_, *listed.leaves, scratch_.near.data(), near_count_, patch);
  }

  // The same where every target is known to have a point within the squared reach.
  HWY_NOINLINE void SearchAgain(int s, size_t p, const TargetLeaves& listed, float squared_reach) {
    if (squared_reach > listed.squared_reach) return SearchUnlisted(s, p, squared_reach);
    Search({listed.leaves, squared_reach, nullptr, {}}, squared_reach, patches_[s][p]);
    TakeNearest(s, p, *listed.leaves);
  }

  // The same where not all leaves within the squared reach are listed: another list has them, unless they are many.
  HWY_NOINLINE void SearchUnlisted(int s, size_t p, float squared_reach) {
    TargetPatch& patch = patches_[s][p];
    LeafList& leaves = scratch_.patch_leaves;
    if (!GatherLeaves(index_, patch.box, squared_reach, CornerScratch::kMaxPatch, leaves, search_.work)) {
      return Descend(s, p);
    }
    Search({&leaves, squared_reach, nullptr, {}}, squared_reach, patch);
    TakeNearest(s, p, leaves);
  }

  // Sets the corners of a patch by a descent of the tree for each target: a ball around it may hold most of the cloud,
  // where others lie beyond the neighborhood of the point.
  HWY_NOINLINE void Descend(int s, size_t p) {
    const TargetPatch& patch = patches_[s][p];
    for (uint32_t used = patch.used; used != 0; used &= used - 1) {
      const int lane = std::countr_zero(used);
      const float target[3] = {patch.x[lane], patch.y[lane], patch.z[lane]};
      const NeighborRank rank =
          KthNeighbor(index_, target, 1, search_.heap, {.stopped = search_.stopped, .work = &search_.work});
      FindByDescent(index_, target, rank, 1, search_);
      if (search_.found.count == 0) continue;  // stopped
      const uint32_t leaf = search_.found.leaves[0];
      const int32_t* const ids = index_.positions(leaf).id;
      const auto place = static_cast<int>(std::find(ids, ids + SpatialIndex::kLeafSize, rank.id) - ids);
      SetCorner(index_, {leaf, place, rank}, points_, p * TargetPatch::kSize + lane, s, hexagram_);
    }
  }

  // A squared distance within which every used target has a point: the one that it belongs to.
  float OwnBound(size_t p, const TargetPatch& patch) const {
    const FloatTag d;
    float farthest = 0.0f;
    for (size_t lane = 0; lane < TargetPatch::kSize; lane += hn::Lanes(d)) {
      const Triple offset = Sub(LoadTriple(points_.query, p * TargetPatch::kSize + lane), LoadTargets(patch, lane));
      const FloatVec squared = SquaredNorm(offset.x, offset.y, offset.z);
      farthest = std::max(
          farthest, hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(MaskFromBits(patch.used >> lane), squared))));
    }
    return farthest;
  }

  // Sets the corners to what the search of these leaves has found.
  HWY_INLINE void TakeNearest(int s, size_t p, const LeafList& leaves) {
    const TargetPatch& patch = patches_[s][p];
    for (uint32_t used = patch.used; used != 0; used &= used - 1) {
      const int lane = std::countr_zero(used);
      const auto position = static_cast<uint32_t>(patch.position[lane]);
      const uint32_t leaf = leaves.leaf(position);
      const uint64_t bits = PointsInBound(index_.positions(leaf), patch, lane);
      IndexedPoint nearest{leaf, std::countr_zero(bits), {}};
      if (HWY_UNLIKELY((patch.tied >> lane & 1) != 0)) {
        search_.work += near_count_ * SpatialIndex::kLeafSize;
        nearest = NearestInBound(index_, leaves, scratch_.near.data(), near_count_, patch, lane);
      } else if (HWY_UNLIKELY((bits & (bits - 1)) != 0)) {
        nearest = NearestInBound(index_, leaves, &position, 1, patch, lane);
      }
      SetCorner(index_, nearest, points_, p * TargetPatch::kSize + lane, s, hexagram_);
    }
  }

  const SpatialIndex& index_;
  const GroupPoints& points_;
  const GroupFrames& frames_;
  SearchScratch& search_;
  CornerScratch& scratch_;
  Hexagram& hexagram_;
  float squared_spacing_ = 0.0f;  // the largest of the group
  size_t near_count_ = 0;         // leaves that were searched last: positions `scratch_.near` of their list
  TargetPatch patches_[6][SpatialIndex::kGroupLeaves];
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_NEAREST_CORNERS_INL_H_
