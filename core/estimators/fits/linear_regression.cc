#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/linear_regression.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/fits/linear_regression-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/lines/refuse_lines-inl.h"
#include "core/estimators/scales/sum_scales-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Writes the results of a group whose problems are set up. `searching` as of RefuseLines.
HWY_INLINE absl::Status WriteLinear(const SpatialIndex& index, const NeighborhoodPlan& plan, GroupScratch& searching,
                                    LinearScratch& s, PointCurvature* results) {
  LinearChecks checks;
  SolveLinear(s.system, s.points, s.shapes, checks);
  RefuseLines(
      index, plan, /*fades=*/false, PointStatus::kSingularFit,
      [&](size_t i) { return checks.spread[i] < kNarrowLinearSpread; },
      [&](size_t i, float* normal) { s.points.normal.Get(i, normal); }, searching, s);
  if (searching.IsStopped()) return Stopped();
  WriteShapes(plan, s.shapes, s, results);
  return absl::OkStatus();
}

absl::Status RegressLinearly(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, LinearScratch& s,
                             PointCurvature* results) {
  const auto fill = [](size_t) {};
  StartGroup(index, group, s, results, fill);
  // Normals that cancel out, as around a pipe, are welcome: there is no frame.
  const auto sum = [&](size_t i, const LeafList&) {
    PreparePoints<false>(OnePoint(), plan, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumLinear(s.neighbors, s.frames.rho[i], i, s.system);
  };
  const absl::Status status = ForEachCollected(index, plan, s.neighbors, s, sum);
  return status.ok() ? WriteLinear(index, plan, s, s, results) : status;
}

absl::Status RegressLinearScales(const SpatialIndex& index, std::span<const NeighborhoodPlan> plans, size_t group,
                                 ScalesScratch<LinearScratch>& s, std::span<PointCurvature* const> results) {
  NeighborArrays& neighbors = s.scales[0]->neighbors;
  QueryPoint query{};
  NormalSums normals;
  const absl::Status status = SumScales<false>(
      index, group, s, results, [&](size_t scale) -> const NeighborhoodPlan& { return plans[scale]; },
      [](LinearScratch&, size_t) {}, query, normals, NeighborCollector(index, query, neighbors, normals),
      [&](size_t scale, size_t i, const LeafList&) {
        LinearScratch& scratch = *s.scales[scale];
        SumLinear(neighbors, scratch.frames.rho[i], i, scratch.system);
      });
  if (!status.ok()) return status;
  for (size_t scale = 0; scale < plans.size(); ++scale) {
    const absl::Status written = WriteLinear(index, plans[scale], *s.scales[0], *s.scales[scale], results[scale]);
    if (!written.ok()) return written;
  }
  s.EndRun();
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "core/estimators/fits/linear_regression.h"
#include "core/estimators/scales/scales_run.h"
#include "core/estimators/single_phase_run.h"

namespace curvd {
namespace {

HWY_EXPORT(RegressLinearly);
HWY_EXPORT(RegressLinearScales);

absl::Status EstimateLinearGroup(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                                 LinearScratch& s, PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(RegressLinearly)(index, plan, group, s, results);
}

absl::Status EstimateLinearScales(const SpatialIndex& index, std::span<const NeighborhoodPlan> plans, size_t group,
                                  ScalesScratch<LinearScratch>& s, std::span<PointCurvature* const> results) {
  return HWY_DYNAMIC_DISPATCH(RegressLinearScales)(index, plans, group, s, results);
}

}  // namespace

size_t LinearRegressionBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t largest = LinearScratch::MostBytes(options, point_count);
  if (options.scale_count() == 1) return largest;
  return ScalesScratch<LinearScratch>::MostBytes(largest, sizeof(LinearScratch), options.scale_count());
}

std::unique_ptr<StrategyRun> StartLinearRegression(const EstimatorOptions& options, const SpatialIndex& index,
                                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<NeighborhoodPlan, LinearScratch>>(
      index, NeighborhoodPlan::Make(options, index), results, EstimateLinearGroup);
}

std::unique_ptr<StrategyRun> StartLinearRegressionScales(const EstimatorOptions& options, const SpatialIndex& index,
                                                         std::span<PointCurvature* const> results) {
  const auto make_plan = [](const EstimatorOptions& scale, const SpatialIndex& of) {
    return NeighborhoodPlan::Make(scale, of);
  };
  return std::make_unique<ScalesRun<NeighborhoodPlan, LinearScratch>>(options, index, results, make_plan,
                                                                      EstimateLinearScales);
}

}  // namespace curvd

#endif  // HWY_ONCE
