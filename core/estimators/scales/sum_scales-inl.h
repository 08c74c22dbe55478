// The steps of an estimate at several scales that all strategies share: one search for the largest, then one scale
// after the other among the neighbors of the one before.

#if defined(CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_
#undef CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_
#endif

#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/scales/narrow-inl.h"
#include "core/estimators/scales/scales_run.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Gives the other scales the points that the first one has loaded.
template <typename Scratch, typename Fill>
HWY_INLINE void CopyPoints(ScalesScratch<Scratch>& s, std::span<PointCurvature* const> results, const Fill& fill) {
  const GroupPoints& points = s.scales[0]->points;
  for (size_t scale = 1; scale < s.scales.size(); ++scale) {
    Scratch& scratch = *s.scales[scale];
    scratch.points = points;
    for (size_t i = 0; i < points.size; ++i) __builtin_prefetch(&results[scale][points.slot[i]], 1);
    for (size_t i = points.size; i < SpatialIndex::kGroupPoints; ++i) {
      scratch.frames.Fill(i);
      fill(scratch, i);
    }
  }
}

// Loads the points of a group, and prepares each at each scale, the largest first: with its frame, if kSetsFrames. For
// each point, `sum(scale, i, leaves)` is called at each scale at which it is still OK, once `visitor` has seen its
// neighbors there, which are in s.scales[0]->search.found, and `leaves` as of ForEachNeighborhood.
// `neighborhood(scale)` is the scale's NeighborhoodPlan; `fill(scratch, i)` as of StartGroup; `query`, `normals`,
// `visitor` and errors as of ForEachNeighborhood.
template <bool kSetsFrames = true, typename Scratch, typename Neighborhood, typename Fill, typename Visitor,
          typename Sum>
HWY_INLINE absl::Status SumScales(const SpatialIndex& index, size_t group, ScalesScratch<Scratch>& s,
                                  std::span<PointCurvature* const> results, const Neighborhood& neighborhood,
                                  const Fill& fill, QueryPoint& query, const NormalSums& normals,
                                  const Visitor& visitor, const Sum& sum) {
  Scratch& largest = *s.scales[0];
  SearchScratch& search = largest.search;
  s.StartRun();
  StartGroup(index, group, largest, results[0], [&](size_t i) { fill(largest, i); });
  CopyPoints(s, results, fill);
  const size_t scale_count = s.scales.size();
  const auto count_at = [&](size_t scale) { return neighborhood(scale).search.searched_count; };
  const auto estimate = [&](size_t scale, size_t i, const LeafList& leaves) {
    Scratch& scratch = *s.scales[scale];
    search.work += search.found.count;
    PreparePoints<kSetsFrames>(OnePoint(), neighborhood(scale), scratch.neighborhoods, i, scratch.points,
                               scratch.frames, [&](size_t j) { fill(scratch, j); });
    if (scratch.points.status[i] == PointStatus::kOk) sum(scale, i, leaves);
  };
  const auto visit = [&](size_t i, const LeafList& leaves) {
    estimate(0, i, leaves);
    Narrower narrower(count_at(1), s.squared_radii[1], search);
    for (size_t scale = 1; scale < scale_count; ++scale) {
      const bool is_last = scale + 1 == scale_count;
      narrower.To(index, count_at(scale), is_last ? 1 : count_at(scale + 1),
                  is_last ? 0.0f : s.squared_radii[scale + 1]);
      const float squared_radius = s.squared_radii[scale] = ShowNeighbors(index, search.found, visitor);
      RecordNeighborhood(index, query, i, squared_radius, normals, search, s.SeamsOf(scale), *s.scales[scale]);
      estimate(scale, i, leaves);
    }
  };
  const absl::Status status = ForEachNeighborhood(index, neighborhood(0), query, normals, visitor, largest, visit);
  if (!status.ok() || largest.rest == 0) return status;
  for (size_t scale = 1; scale < scale_count; ++scale) s.scales[scale]->LeaveRest(largest.points.size);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_
