// The steps of an estimate that all strategies share: load a group, find its neighborhoods, prepare its points.

#if defined(CURVD_CORE_ESTIMATORS_GROUP_ESTIMATE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_GROUP_ESTIMATE_INL_H_
#undef CURVD_CORE_ESTIMATORS_GROUP_ESTIMATE_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_GROUP_ESTIMATE_INL_H_
#endif

#include "absl/status/status.h"
#include "core/estimators/frames-inl.h"
#include "core/estimators/group_points-inl.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/neighbors/neighbors-inl.h"
#include "core/estimators/seams/find_seam-inl.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Loads the query points of a group, from s.first_point on. `fill(i)` gives what is no point of the group values that
// no kernel trips over, as frames.Fill(i) does.
template <typename Fill>
HWY_INLINE void StartGroup(const SpatialIndex& index, size_t group, GroupScratch& s, PointCurvature* results,
                           Fill fill) {
  LoadGroup(index, group, s.points, s.first_point);
  // Results are in another order; they are written when all are done.
  for (size_t i = 0; i < s.points.size; ++i) __builtin_prefetch(&results[s.points.slot[i]], 1);
  for (size_t i = s.points.size; i < SpatialIndex::kGroupPoints; ++i) {
    s.frames.Fill(i);
    fill(i);
  }
}

// Looks for a seam in the neighborhood that the last search found of the point at a place of the tree order: marks the
// point if it may be beside one.
HWY_NOINLINE inline void LookForSeam(const SpatialIndex& index, const QueryPoint& query, size_t place,
                                     SearchScratch& search, SeamMarks& seams) {
  // A step for each point of the leaves, twice: more passes read vectors of them.
  search.work += 2 * search.found.leaf_count * SpatialIndex::kLeafSize;
  const SeamFinding finding = FindSeam(index, search.found, query);
  if (finding.may_be_beside_seam) seams.Mark(place, finding.is_beside_seam);
}

// Whether one of the neighbors that the last search found has no normal (SpatialIndex::lacks_normals).
HWY_NOINLINE inline bool HoldsPointWithoutNormal(const SpatialIndex& index, SearchScratch& search) {
  const FloatTag d;
  search.work += search.found.leaf_count * SpatialIndex::kLeafSize;
  size_t count = 0;
  const auto look = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    const FloatVec x = hn::Load(d, index.normals(near.leaf).x + near.place);
    count += hn::CountTrue(d, hn::AndNot(hn::Eq(x, x), inside));
  };
  ForEachInside(index, search.found, look);
  return count > 0;
}

// Records the neighborhood of point i, which the last search found, and looks for a seam in it unless `seams` is null.
// With a neighbor that has no normal, the sum of normals is 0, as if they canceled out.
HWY_INLINE void RecordNeighborhood(const SpatialIndex& index, const QueryPoint& query, size_t i, float squared_radius,
                                   const NormalSums& normals, SearchScratch& search, SeamMarks* seams,
                                   GroupScratch& s) {
  s.neighborhoods.squared_radius[i] = squared_radius;
  s.neighborhoods.count[i] = static_cast<float>(search.found.count);
  s.neighborhoods.normal_sum.Set(i, normals.sum);
  s.neighborhoods.agreement[i] = normals.least_agreement;
  if (HWY_UNLIKELY(index.lacks_normals()) && HoldsPointWithoutNormal(index, search)) {
    constexpr float kNothing[3] = {};
    s.neighborhoods.normal_sum.Set(i, kNothing);
  }
  if (HWY_UNLIKELY(normals.least_agreement < kNoneOpposed) && seams != nullptr) {
    LookForSeam(index, query, static_cast<size_t>(s.points.place[i]), search, *seams);
  }
}

// Finds the neighborhood of each point of the group, records its size, looks for seams, and calls `visit(i, leaves)`
// with the leaves that were searched, to which s.search.found.positions refers. `visitor` sees each neighborhood first;
// it must set `normals`. `query` is the point of the moment, for visitors that refer to it.
// Returns an error at the first neighborhood that is too large, and once the scratch is stopped. A group without points
// searches nothing, and leaves what searches have learned to the next one. Ends the group after the point with which
// the run has become long.
template <typename Visitor, typename Visit>
HWY_INLINE absl::Status ForEachNeighborhood(const SpatialIndex& index, const NeighborhoodPlan& plan, QueryPoint& query,
                                            const NormalSums& normals, const Visitor& visitor, GroupScratch& s,
                                            Visit visit) {
  if (s.points.size == 0) return absl::OkStatus();
  const uint64_t began = s.search.work;
  s.search.stopped = s.stopped;
  GroupSearch search(index, plan.search, s.points.box, s.search);
  for (size_t i = 0; i < s.points.size; ++i) {
    s.points.query.Get(i, query.position);
    s.points.normal.Get(i, query.normal);
    const float squared_radius = search.Find(query.position, visitor);
    if (s.IsStopped()) return Stopped();
    if (squared_radius == GroupSearch::kTooLarge) {
      return NeighborhoodTooLarge(plan, index.point_set().place_of(s.points.rank[i]));
    }
    RecordNeighborhood(index, query, i, squared_radius, normals, s.search, s.seams, s);
    visit(i, search.leaves());
    if (HWY_UNLIKELY(s.IsLongSince(began)) && i + 1 < s.points.size) s.LeaveRest(i + 1);
  }
  search.PassOn();
  return absl::OkStatus();
}

// The same where only the sums of the neighbors' normals are wanted.
template <typename Visit>
HWY_INLINE absl::Status ForEachNormalSum(const SpatialIndex& index, const NeighborhoodPlan& plan, GroupScratch& s,
                                         Visit visit) {
  QueryPoint query{};
  NormalSums normals;
  return ForEachNeighborhood(index, plan, query, normals, NormalSummer(index, query, normals), s, visit);
}

// The same where the neighbors are wanted: they are in `neighbors` when `visit` is called.
template <typename Visit>
HWY_INLINE absl::Status ForEachCollected(const SpatialIndex& index, const NeighborhoodPlan& plan,
                                         NeighborArrays& neighbors, GroupScratch& s, Visit visit) {
  QueryPoint query{};
  NormalSums normals;
  const NeighborCollector collector(index, query, neighbors, normals);
  return ForEachNeighborhood(index, plan, query, normals, collector, s, visit);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_GROUP_ESTIMATE_INL_H_
