#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/triangles/independent.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <algorithm>
#include <utility>

#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/principal-inl.h"
#include "core/estimators/triangles/random_triangles-inl.h"
#include "core/estimators/triangles/random_words-inl.h"
#include "core/estimators/triangles/ranked_neighbors-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Puts `drawn` times three elements of `order`, drawn from all `count`, at its beginning: a word tells those of three
// places.
HWY_INLINE void DrawToFront(RandomWords& random, size_t count, size_t drawn, uint32_t* order) {
  const WordTag d;
  alignas(64) uint64_t other[3][SpatialIndex::kLeafSize / 2];
  for (size_t t = 0; t < drawn; t += hn::Lanes(d)) {
    WordVec bits = random.Next();
    const WordVec lane = hn::Iota(d, 0);
    WordVec place = hn::Add(hn::Set(d, 3 * t), hn::Add(lane, hn::Add(lane, lane)));
    for (int c = 0; c < 3; ++c) {
      hn::Store(hn::Add(place, Draw21(bits, hn::Sub(hn::Set(d, count), place))), d, other[c]);
      bits = hn::ShiftRight<21>(bits);
      place = hn::Add(place, hn::Set(d, 1));
    }
    const size_t here = std::min(hn::Lanes(d), drawn - t);
    for (size_t k = 0; k < here; ++k) {
      for (size_t c = 0; c < 3; ++c) std::swap(order[3 * (t + k) + c], order[other[c][k]]);
    }
  }
}

// Disjoint triangles over one shuffle of the neighbors of point i, which were just found in `leaves`: a third as many
// as there are, at most `triangle_count`.
HWY_NOINLINE inline void MeasureIndependent(const SpatialIndex& index, const TrianglePlan& plan, const LeafList& leaves,
                                            size_t i, TriangleScratch& s) {
  const size_t count = ListRanked(index, leaves, s);
  const size_t triangles = std::min<size_t>(plan.triangle_count, count / 3);
  uint32_t* const order = s.order.data();
  RandomWords random(RandomStream(plan.seed, index.point_set().seed_of(s.points.rank[i])));
  DrawToFront(random, count, triangles, order);
  std::fill_n(order + count, TriangleScratch::kOrderPad, 0u);
  const float* const rows = s.rows.row(0);
  const auto draw = [&](size_t t) HWY_ATTR {
    return [rows, corners = order + 3 * t](int c, size_t lane) HWY_ATTR { return rows + corners[3 * lane + c]; };
  };
  MeasureTriangles(i, triangles, draw, s);
  s.search.work += count + triangles;
}

absl::Status EstimateIndependent(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                                 PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.measures.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto measure = [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) MeasureIndependent(index, plan, leaves, i, s);
  };
  const absl::Status status = ForEachNormalSum(index, plan.neighborhood, s, measure);
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
