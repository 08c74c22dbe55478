#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/aso.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/fits/algebraic_sphere-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/fits/sphere_field-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/lines/refuse_lines-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

absl::Status EstimateSpheres(const SpatialIndex& index, const SpherePlan& sphere, size_t group, SphereScratch& s,
                             PointCurvature* results) {
  const NeighborhoodPlan& plan = sphere.neighborhood;
  const auto fill = [](size_t) {};
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList&) {
    PreparePoints(OnePoint(), plan, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumSphere(s.neighbors, s.frames.rho[i], i, s.columns, s.system);
  };
  const absl::Status status = ForEachCollected(index, plan, s.neighbors, s, sum);
  if (!status.ok()) return status;
  GroupScalars spread;
  SolveSpheres(s.system, sphere.project, s.points, s.shapes, spread);
  RefuseLines(
      index, plan, /*fades=*/true, PointStatus::kSingularFit, [&](size_t i) { return spread[i] < kNarrowSphereSpread; },
      s, s);
  if (s.IsStopped()) return Stopped();
  WriteShapes(plan, s.shapes, s, results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <array>

#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(EstimateSpheres);

absl::Status EstimateGroup(const SpatialIndex& index, const SpherePlan& plan, size_t group, SphereScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateSpheres)(index, plan, group, s, results);
}

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  return SphereScratch::MostBytes(options, point_count, kSphereColumns, kMostInSphereColumns);
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<SpherePlan, SphereScratch>>(index, SpherePlan(options, index), results,
                                                                     EstimateGroup);
}

constexpr std::array<OptionName, 1> kOptions = {"project"};

}  // namespace

extern const Strategy kAso = {
    .name = "aso",
    .wire_name = "ALGEBRAIC_SHAPE_OPERATOR",
    .summary = "an algebraic sphere fitted to positions and normals, and the derivative of its gradient",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = MostScratchBytes,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
