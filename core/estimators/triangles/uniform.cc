#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/triangles/uniform.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
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

// Numbers of the corners of one vector of triangles.
struct CornerNumbers {
  alignas(64) int32_t corner[3][SpatialIndex::kLeafSize];
};

// Draws three distinct numbers below `count` for each triangle, by one word each.
HWY_INLINE void DrawDistinct(RandomWords& random, size_t count, CornerNumbers& out) {
  const WordTag words;
  const IntTag d;
  const WordVec first = random.Next();
  // A vector of numbers takes two of words, but for scalar code.
  const WordVec second = hn::Lanes(words) < hn::Lanes(d) ? random.Next() : first;
  const WordVec all = hn::Set(words, count), all_but_one = hn::Set(words, count - 1),
                others = hn::Set(words, count - 2);
  const auto a = NarrowWords(Draw21(first, all), Draw21(second, all));
  auto b = NarrowWords(Draw21(hn::ShiftRight<21>(first), all_but_one), Draw21(hn::ShiftRight<21>(second), all_but_one));
  auto c = NarrowWords(Draw21(hn::ShiftRight<42>(first), others), Draw21(hn::ShiftRight<42>(second), others));
  // Numbers that are not below one that is taken become one higher; a mask is -1 where it is true.
  const auto skip = [d, one = hn::Set(d, 1)](auto number, auto taken)
                        HWY_ATTR { return hn::Add(hn::Add(number, one), hn::VecFromMask(d, hn::Lt(number, taken))); };
  b = skip(b, a);
  c = skip(skip(c, hn::Min(a, b)), hn::Max(a, b));
  hn::Store(a, d, out.corner[0]);
  hn::Store(b, d, out.corner[1]);
  hn::Store(c, d, out.corner[2]);
}

// `triangle_count` triangles with corners drawn uniformly from the neighbors of point i, the point included, which were
// just found in `leaves`.
HWY_NOINLINE inline void MeasureUniform(const SpatialIndex& index, const TrianglePlan& plan, const LeafList& leaves,
                                        size_t i, TriangleScratch& s) {
  const size_t count = ListRanked(index, leaves, s);
  const uint32_t* const order = s.order.data();
  const float* const rows = s.rows.row(0);
  RandomWords random(RandomStream(plan.seed, index.point_set().seed_of(s.points.rank[i])));
  CornerNumbers numbers;
  const auto draw = [&](size_t) HWY_ATTR {
    DrawDistinct(random, count, numbers);
    return [&](int c, size_t lane) HWY_ATTR { return rows + order[static_cast<uint32_t>(numbers.corner[c][lane])]; };
  };
  MeasureTriangles(i, plan.triangle_count, draw, s);
  s.search.work += plan.triangle_count;
}

absl::Status EstimateUniform(const SpatialIndex& index, const TrianglePlan& plan, size_t group, TriangleScratch& s,
                             PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.measures.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto measure = [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) MeasureUniform(index, plan, leaves, i, s);
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
