#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scale/collect.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/scale/collect.h"
#include "core/scale/pilot_collect-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

absl::Status CollectEachKernel(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                               CollectedPoints which, PilotScratch& s, absl::FunctionRef<bool(size_t)> keep,
                               absl::FunctionRef<void(size_t)> visit) {
  if (which == CollectedPoints::kAll) {
    LoadGroup<true>(index, group, s.points, s.first_point);
  } else {
    LoadGroup(index, group, s.points, s.first_point);
  }
  KeepPoints(keep, s.points);
  QueryPoint query;
  NormalSums normals;
  const NumberedCollector collector(index, query, s, normals);
  return ForEachNeighborhood(index, plan, query, normals, collector, s, [&](size_t i, const LeafList&) { visit(i); });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {

HWY_EXPORT(CollectEachKernel);

absl::Status CollectNeighbors(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                              CollectedPoints which, PilotScratch& scratch, absl::FunctionRef<bool(size_t i)> keep,
                              absl::FunctionRef<void(size_t i)> visit) {
  return HWY_DYNAMIC_DISPATCH(CollectEachKernel)(index, plan, group, which, scratch, keep, visit);
}

}  // namespace curvd

#endif  // HWY_ONCE
