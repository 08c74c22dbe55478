#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/triangles/independent.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <algorithm>
#include <utility>

#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/principal-inl.h"
#include "core/estimators/triangles/random_triangles-inl.h"
#include "core/estimators/triangles/ranked_neighbors-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Disjoint triangles over one shuffle of the neighbors of point i: a third as many as there are, at most
// `triangle_count`.
HWY_NOINLINE inline void MeasureIndependent(const TrianglePlan& plan, size_t i, TriangleScratch& s) {
  RandomStream random(plan.seed, s.points.seed[i]);
  const size_t count = s.neighbors.count;
  const size_t triangles = std::min<size_t>(plan.triangle_count, count / 3);
  uint32_t* order = s.order.data();
  size_t next = 0;
  const auto draw = [&](int lane, CornerIndices& indices) {
    uint64_t bits = random.Next();
    for (int c = 0; c < 3; ++c, ++next, bits >>= 21) {
      std::swap(order[next], order[next + Draw21(bits, static_cast<uint32_t>(count - next))]);
      indices.corner[c][lane] = static_cast<int32_t>(order[next]);
    }
  };
  MeasureTriangles(s.neighbors, i, triangles, draw, s);
  s.search.work += count + triangles;
}

absl::Status EstimateIndependent(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                                 PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.measures.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto measure = [&](size_t i, const LeafList&) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) MeasureIndependent(plan, i, s);
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

HWY_EXPORT(EstimateIndependent);

absl::Status EstimateGroup(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateIndependent)(index, plan, group, s, results);
}

constexpr std::array<OptionName, 2> kOptions = {"triangle_count", "seed"};

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<TrianglePlan, TriangleScratch>>(index, TrianglePlan(options, index), results,
                                                                         EstimateGroup);
}

}  // namespace

extern const Strategy kIndependent = {
    .name = "independent",
    .wire_name = {},
    .summary = "disjoint triangles from one shuffle of the neighborhood, at most a third of its size",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = TriangleScratch::MostBytes,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
