#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/triangles/uniform.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/principal-inl.h"
#include "core/estimators/triangles/random_triangles-inl.h"
#include "core/estimators/triangles/ranked_neighbors-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// `triangle_count` triangles with corners drawn uniformly from the neighbors of point i, the point included.
HWY_NOINLINE inline void MeasureUniform(const TrianglePlan& plan, size_t i, TriangleScratch& s) {
  RandomStream random(plan.seed, s.points.seed[i]);
  const auto count = static_cast<uint32_t>(s.neighbors.count);
  const uint32_t* const order = s.order.data();
  const auto draw = [&](int lane, CornerIndices& indices) { DrawDistinct(random, count, order, lane, indices); };
  MeasureTriangles(s.neighbors, i, plan.triangle_count, draw, s);
  s.search.work += plan.triangle_count;
}

absl::Status EstimateUniform(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                             PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.measures.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto measure = [&](size_t i, const LeafList&) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) MeasureUniform(plan, i, s);
  };
  const absl::Status status = ForEachRanked(index, plan.neighborhood, s, measure);
  if (status.ok()) WriteMeasured(index, plan.neighborhood, kUsualTriangleArea, s, s, results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <array>

#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(EstimateUniform);

absl::Status EstimateGroup(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateUniform)(index, plan, group, s, results);
}

constexpr std::array<OptionName, 2> kOptions = {"triangle_count", "seed"};

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<TrianglePlan, TriangleScratch>>(index, TrianglePlan(options, index), results,
                                                                         EstimateGroup);
}

}  // namespace

extern const Strategy kUniform = {
    .name = "uniform",
    .wire_name = {},
    .summary = "triangle_count triangles with corners drawn uniformly from the neighborhood",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = TriangleScratch::MostBytes,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
