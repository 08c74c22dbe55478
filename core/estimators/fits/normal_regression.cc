#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/normal_regression.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/fits/normal_regression-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/scales/sum_scales-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

absl::Status RegressNormals(const SpatialIndex& index, const RegressionPlan& regression, size_t group,
                            RegressionScratch& s, PointCurvature* results) {
  const NeighborhoodPlan& plan = regression.neighborhood;
  const auto fill = [](size_t) {};
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList&) {
    PreparePoints(OnePoint(), plan, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumRegression(s.neighbors, s.frames, i, regression.degree, s.system);
  };
  const absl::Status status = ForEachCollected(index, plan, s.neighbors, s, sum);
  if (!status.ok()) return status;
  SolveRegressions(index, plan, s, s);
  if (s.IsStopped()) return Stopped();
  WriteShapes(plan, s.shapes, s, results);
  return status;
}

absl::Status RegressNormalScales(const SpatialIndex& index, std::span<const RegressionPlan> plans, size_t group,
                                 ScalesScratch<RegressionScratch>& s, std::span<PointCurvature* const> results) {
  NeighborArrays& neighbors = s.scales[0]->neighbors;
  QueryPoint query{};
  NormalSums normals;
  const absl::Status status = SumScales(
      index, group, s, results, [&](size_t scale) -> const NeighborhoodPlan& { return plans[scale].neighborhood; },
      [](RegressionScratch&, size_t) {}, query, normals, NeighborCollector(index, query, neighbors, normals),
      [&](size_t scale, size_t i, const LeafList&) {
        SumRegression(neighbors, s.scales[scale]->frames, i, plans[scale].degree, s.scales[scale]->system);
      });
  if (!status.ok()) return status;
  for (size_t scale = 0; scale < plans.size(); ++scale) {
    RegressionScratch& scratch = *s.scales[scale];
    SolveRegressions(index, plans[scale].neighborhood, *s.scales[0], scratch);
    if (s.scales[0]->IsStopped()) return Stopped();
    WriteShapes(plans[scale].neighborhood, scratch.shapes, scratch, results[scale]);
  }
  s.EndRun();
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <array>

#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/fits/linear_regression.h"
#include "core/estimators/scales/scales_run.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(RegressNormals);
HWY_EXPORT(RegressNormalScales);

absl::Status EstimateGroup(const SpatialIndex& index, const RegressionPlan& plan, size_t group, RegressionScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(RegressNormals)(index, plan, group, s, results);
}

absl::Status EstimateScales(const SpatialIndex& index, std::span<const RegressionPlan> plans, size_t group,
                            ScalesScratch<RegressionScratch>& s, std::span<PointCurvature* const> results) {
  return HWY_DYNAMIC_DISPATCH(RegressNormalScales)(index, plans, group, s, results);
}

// Degree 1 is fitted over space, not over the tangent plane.
bool IsLinear(const EstimatorOptions& options) { return options.regression_degree == 1; }

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  if (IsLinear(options)) return LinearRegressionBytes(options, point_count);
  const size_t largest = RegressionScratch::MostBytes(options, point_count);
  if (options.scale_count() == 1) return largest;
  return ScalesScratch<RegressionScratch>::MostBytes(largest, sizeof(RegressionScratch), options.scale_count());
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  if (IsLinear(options)) return StartLinearRegression(options, index, results);
  return std::make_unique<SinglePhaseRun<RegressionPlan, RegressionScratch>>(index, RegressionPlan(options, index),
                                                                             results, EstimateGroup);
}

std::unique_ptr<StrategyRun> StartScales(const EstimatorOptions& options, const SpatialIndex& index,
                                         std::span<PointCurvature* const> results) {
  if (IsLinear(options)) return StartLinearRegressionScales(options, index, results);
  const auto make_plan = [](const EstimatorOptions& scale, const SpatialIndex& of) {
    return RegressionPlan(scale, of);
  };
  return std::make_unique<ScalesRun<RegressionPlan, RegressionScratch>>(options, index, results, make_plan,
                                                                        EstimateScales);
}

constexpr std::array<OptionName, 1> kOptions = {"regression_degree"};

}  // namespace

extern const Strategy kNormalRegression = {
    .name = "normal-regression",
    .wire_name = {},
    .summary = "polynomials of degree regression_degree fitted to the neighbors' normals, and their derivative",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = MostScratchBytes,
    .start = Start,
    .start_scales = StartScales};

}  // namespace curvd

#endif  // HWY_ONCE
