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

// Keeps the neighbors of point i at the next smaller scale, whose scratch and number of neighbors those are, and looks
// for a seam among them as ForEachNeighborhood does.
template <typename Scratch>
HWY_INLINE void NarrowTo(const SpatialIndex& index, size_t count, const QueryPoint& query, size_t i,
                         SearchScratch& search, SeamMarks* seams, RingNeighbors& ring, float& squared_radius,
                         Scratch& scratch) {
  NormalSums normals;
  search.work += ring.neighbors.count;
  search.found.last = Narrow(count, query, ring, squared_radius, normals);
  search.found.count = count;
  scratch.neighborhoods.squared_radius[i] = squared_radius;
  scratch.neighborhoods.count[i] = static_cast<float>(count);
  scratch.neighborhoods.normal_sum.Set(i, normals.sum);
  scratch.neighborhoods.agreement[i] = normals.least_agreement;
  if (HWY_UNLIKELY(normals.least_agreement < kNoneOpposed) && seams != nullptr) {
    LookForSeam(index, query, static_cast<size_t>(scratch.points.place[i]), search, *seams);
  }
}

// Loads the points of a group, and prepares each at each scale, the largest first. For each point, `start(i)` is called
// once its neighbors at the largest scale are in s.ring, then `sum(scale, i)` at each scale at which it has a frame,
// when s.ring has those of that scale. `neighborhood(scale)` is the scale's NeighborhoodPlan; `fill(scratch, i)` as of
// StartGroup. Errors as those of ForEachNeighborhood.
template <typename Scratch, typename Neighborhood, typename Fill, typename Start, typename Sum>
HWY_INLINE absl::Status SumScales(const SpatialIndex& index, size_t group, ScalesScratch<Scratch>& s,
                                  std::span<PointCurvature* const> results, const Neighborhood& neighborhood,
                                  const Fill& fill, const Start& start, const Sum& sum) {
  Scratch& largest = *s.scales[0];
  s.StartRun();
  StartGroup(index, group, largest, results[0], [&](size_t i) { fill(largest, i); });
  CopyPoints(s, results, fill);
  QueryPoint query;
  NormalSums normals;
  const RingCollector collector(index, query, s.ring, normals);
  const auto estimate = [&](size_t scale, size_t i) {
    Scratch& scratch = *s.scales[scale];
    largest.search.work += s.ring.neighbors.count;
    PreparePoints(OnePoint(), neighborhood(scale), scratch.neighborhoods, i, scratch.points, scratch.frames,
                  [&](size_t j) { fill(scratch, j); });
    if (scratch.points.status[i] == PointStatus::kOk) sum(scale, i);
  };
  const auto visit = [&](size_t i, const LeafList&) {
    start(i);
    estimate(0, i);
    float squared_radius = largest.neighborhoods.squared_radius[i];
    for (size_t scale = 1; scale < s.scales.size(); ++scale) {
      SeamMarks* const seams = s.seams == nullptr ? nullptr : s.seams + scale;
      NarrowTo(index, neighborhood(scale).search.searched_count, query, i, largest.search, seams, s.ring,
               squared_radius, *s.scales[scale]);
      estimate(scale, i);
    }
  };
  const absl::Status status = ForEachNeighborhood(index, neighborhood(0), query, normals, collector, largest, visit);
  if (!status.ok() || largest.rest == 0) return status;
  for (size_t scale = 1; scale < s.scales.size(); ++scale) s.scales[scale]->LeaveRest(largest.points.size);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_SCALES_SUM_SCALES_INL_H_
