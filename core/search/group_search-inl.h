// Finds the neighborhoods of the queries of one group, one after the other.

#if defined(CURVD_CORE_SEARCH_GROUP_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_SEARCH_GROUP_SEARCH_INL_H_
#undef CURVD_CORE_SEARCH_GROUP_SEARCH_INL_H_
#else
#define CURVD_CORE_SEARCH_GROUP_SEARCH_INL_H_
#endif

#include <algorithm>

#include "core/search/neighborhood-inl.h"
#include "core/search/search_plan.h"
#include "core/search/search_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Shows the neighbors that were found to a copy of `visitor`, and returns the largest squared distance of one. A
// visitor takes what it wants of the neighbors:
//   void Start(size_t count);                                       their number, before any of them
//   void operator()(const NearPoints& points, FloatMask inside);    a visit of ForEachInside
//   void Finish();                                                  after all of them
// It is copied for each query, so that its sums stay in registers: Finish stores them where the caller wants them.
template <typename Visitor>
HWY_INLINE float ShowNeighbors(const SpatialIndex& index, const Neighborhood& found, Visitor visitor) {
  visitor.Start(found.count);
  const float farthest = ForEachInside(index, found, visitor);
  visitor.Finish();
  return farthest;
}

// Queries near each other share one list of leaves as long as that pays; one in uneven surroundings goes down the tree
// by itself. What is found depends on the query alone.
class GroupSearch {
 public:
  // What Find returns in place of a distance for a neighborhood of more than plan.max_neighbor_count points.
  static constexpr float kTooLarge = -1.0f;

  // `box` holds all queries.
  GroupSearch(const SpatialIndex& index, const SearchPlan& plan, const Box& box, SearchScratch& scratch)
      : index_(index), plan_(plan), box_(box), scratch_(scratch), growth_(GuessGrowth(plan.searched_count)) {
    plan.by_radius ? static_cast<void>(List(plan.squared_radius)) : StartReach();
  }

  // Finds the neighborhood of the point query[0..2], and shows it to `visitor` as ShowNeighbors does. Returns the
  // largest squared distance of a neighbor, or kTooLarge, by radius, if it is too large: then the visitor sees nothing.
  // scratch.found has the neighborhood until the next call; once the scratch is stopped, it may be part of it.
  template <typename Visitor>
  HWY_INLINE float Find(const float* query, const Visitor& visitor) {
    return plan_.by_radius ? FindInRadius(query, visitor) : FindNearest(query, visitor);
  }

  // The leaves that were searched last: scratch.found.positions points there.
  const LeafList& leaves() const { return listed_ ? scratch_.group_leaves : scratch_.query_leaves; }

  // Lets the next group's search start from what this one has learned.
  void PassOn() { scratch_.reach_hint = largest_; }

 private:
  bool List(float squared_reach) {
    squared_reach_ = squared_reach;
    return listed_ = GatherLeaves(index_, box_, squared_reach, plan_.max_listed_leaves(), scratch_.group_leaves,
                                  scratch_.work);
  }

  void StartReach() {
    constexpr int kMaxHalvings = 12;
    float diagonal = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = box_.hi[axis] - box_.lo[axis];
      diagonal += extent * extent;
    }
    // 1.2 times the last group's: the density of a scan changes slowly.
    float squared_reach = scratch_.reach_hint > 0.0f ? scratch_.reach_hint * 1.44f : diagonal;
    for (int i = 0; i < kMaxHalvings && !List(squared_reach); ++i) squared_reach *= 0.25f;
  }

  HWY_INLINE void LocateNearest(const float* query) {
    const size_t k = plan_.searched_count;
    while (listed_) {
      const DistanceRange guess = last_ > 0.0f ? DistanceRange{last_ / growth_, last_ * growth_}
                                               : DistanceRange{DistanceRange::kNoLow, squared_reach_};
      if (NearestInReach(index_, scratch_.group_leaves, query, k, guess, squared_reach_, scratch_)) return;
      if (squared_reach_ <= 0.0f || squared_reach_ > kWholeIndex)
        listed_ = false;
      else
        List(squared_reach_ * 2.0f);
    }
    const NeighborRank last =
        KthNeighbor(index_, query, k, scratch_.heap, {.stopped = scratch_.stopped, .work = &scratch_.work});
    FindByDescent(index_, query, last, k, scratch_);
  }

  template <typename Visitor>
  HWY_NOINLINE float FindNearest(const float* query, const Visitor& visitor) {
    LocateNearest(query);
    last_ = Show(visitor);
    largest_ = std::max(largest_, last_);
    return last_;
  }

  template <typename Visitor>
  HWY_NOINLINE float FindInRadius(const float* query, const Visitor& visitor) {
    Neighborhood& found = scratch_.found;
    if (listed_) {
      CullLeaves(scratch_.group_leaves, query, squared_reach_, found);
      found.count =
          MeasureDistances(index_, query, {DistanceRange::kNoLow, squared_reach_}, found, scratch_.inner_distances)
              .inside;
      found.last = {squared_reach_, SpatialIndex::kPaddingId};
    } else {
      FindByDescent(index_, query, {squared_reach_, SpatialIndex::kPaddingId}, plan_.max_neighbor_count, scratch_);
    }
    if (found.count <= plan_.max_neighbor_count) return Show(visitor);
    CountWork(leaves(), scratch_);
    return kTooLarge;
  }

  template <typename Visitor>
  HWY_INLINE float Show(const Visitor& visitor) {
    CountWork(leaves(), scratch_);
    return ShowNeighbors(index_, scratch_.found, visitor);
  }

  static constexpr float kWholeIndex = 0x1p126f;  // no two points are farther apart: SpatialIndex::kFarthest

  const SpatialIndex& index_;
  const SearchPlan& plan_;
  const Box& box_;
  SearchScratch& scratch_;
  const float growth_;          // of the squared radius, from one neighborhood to the next
  float squared_reach_ = 0.0f;  // all points within it of a query lie in listed leaves
  float last_ = 0.0f;
  float largest_ = 0.0f;
  bool listed_ = false;  // whether group_leaves serves
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_SEARCH_GROUP_SEARCH_INL_H_
