#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/hexagram/hexagram.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/hexagram/hexagram-inl.h"
#include "core/estimators/hexagram/nearest_corners-inl.h"
#include "core/estimators/principal-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Area of the two triangles of a hexagram whose corners lie at its targets, in units of rho^2.
inline constexpr float kUsualHexagramArea = 2.6f;

absl::Status EstimateHexagrams(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                               HexagramScratch& s, PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.Fill(i); };
  StartGroup(index, group, s, results, fill);
  // All neighborhoods first, then all corners.
  const absl::Status status = ForEachNormalSum(index, plan, s, [](size_t, const LeafList&) {});
  if (!status.ok() || s.points.size == 0) return status;
  const FloatTag d;
  for (size_t i = 0; i < s.points.size; i += hn::Lanes(d)) {
    PreparePoints(d, plan, s.neighborhoods, i, s.points, s.frames, fill);
  }
  CornerSearch(index, s.points, s.frames, s.search, s.corners, s.hexagram).SetCorners();
  if (s.IsStopped()) return Stopped();
  MeasureHexagrams(&s.hexagram, 1, s);
  WriteMeasured(index, plan, kUsualHexagramArea, s, s, results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "core/estimators/hexagram/hexagram_scratch.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(EstimateHexagrams);

absl::Status EstimateGroup(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, HexagramScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateHexagrams)(index, plan, group, s, results);
}

// The search only sets the scale: that many neighbors measure the density, and more of them would make its cost grow
// with K.
constexpr size_t kMostSearched = 48;

NeighborhoodPlan MakePlan(const EstimatorOptions& options, const SpatialIndex& index) {
  // Targets at two thirds of the radius that holds K points (docs/numerics.md, measured).
  constexpr float kTargets = 2.0f / 3.0f;
  NeighborhoodPlan plan = NeighborhoodPlan::Make(options, index, kMostSearched);
  plan.rho_factor *= kTargets;
  return plan;
}

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  return sizeof(HexagramScratch) + SearchScratchBytes(SearchSizes(options, kMostSearched), point_count) +
         CornerScratch::MostBytes(point_count) + ScratchArray<NeighborRank>::MostBytes(1);
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<NeighborhoodPlan, HexagramScratch>>(index, MakePlan(options, index), results,
                                                                             EstimateGroup);
}

}  // namespace

extern const Strategy kHexagram = {.name = "hexagram",
                                   .wire_name = {},
                                   .summary = "two triangles over the points nearest to the six corners of a hexagram",
                                   .options = {},
                                   .needs_normals = true,
                                   .bytes_per_point = 0,
                                   .scratch_bytes = MostScratchBytes,
                                   // The point itself lies at rho, 2/3 of the radius, from each target.
                                   .reach_factor = 4.0 / 3.0,
                                   .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
