#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/normal_regression.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/fits/normal_regression-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

absl::Status RegressNormals(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, RegressionScratch& s,
                            PointCurvature* results) {
  const auto fill = [](size_t) {};
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList&) {
    PreparePoints(OnePoint(), plan, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumRegression(s.neighbors, s.frames, i, s.system);
  };
  const absl::Status status = ForEachCollected(index, plan, s.neighbors, s, sum);
  if (!status.ok()) return status;
  SolveRegressions(index, plan, s);
  if (s.IsStopped()) return Stopped();
  WriteShapes(plan, s.shapes, s, results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(RegressNormals);

absl::Status EstimateGroup(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, RegressionScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(RegressNormals)(index, plan, group, s, results);
}

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  return RegressionScratch::MostBytes(options, point_count, 0);
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<NeighborhoodPlan, RegressionScratch>>(
      index, NeighborhoodPlan::Make(options, index), results, EstimateGroup);
}

}  // namespace

extern const Strategy kNormalRegression = {
    .name = "normal-regression",
    .wire_name = {},
    .summary = "a cubic polynomial fitted to the neighbors' normals over the tangent plane, and its derivative",
    .options = {},
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = MostScratchBytes,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
