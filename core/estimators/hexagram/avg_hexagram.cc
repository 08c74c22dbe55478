#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/hexagram/avg_hexagram.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/hexagram/hexagram-inl.h"
#include "core/estimators/hexagram/sector_sums-inl.h"
#include "core/estimators/principal-inl.h"
#include "core/estimators/scales/sum_scales-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Area of the triangles of all hexagrams over a neighborhood that fills a disc, in units of rho^2.
HWY_INLINE float UsualArea(const AvgHexagramPlan& plan) {
  constexpr float kOfOneHexagram = 1.05f;
  return static_cast<float>(plan.rotations) * kOfOneHexagram;
}

absl::Status EstimateAvgHexagrams(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t group,
                                  AvgHexagramScratch& s, PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumHexagrams(index, plan, leaves, i, s, s);
  };
  const absl::Status status = ForEachNormalSum(index, plan.neighborhood, s, sum);
  if (!status.ok()) return status;
  MeasureHexagrams(s.hexagrams, plan.rotations, s);
  WriteMeasured(index, plan.neighborhood, UsualArea(plan), s, s, results);
  return status;
}

absl::Status EstimateHexagramScales(const SpatialIndex& index, std::span<const AvgHexagramPlan> plans, size_t group,
                                    ScalesScratch<AvgHexagramScratch>& s, std::span<PointCurvature* const> results) {
  AvgHexagramScratch& largest = *s.scales[0];
  QueryPoint query{};
  NormalSums normals;
  const absl::Status status = SumScales(
      index, group, s, results, [&](size_t scale) -> const NeighborhoodPlan& { return plans[scale].neighborhood; },
      [](AvgHexagramScratch& scratch, size_t i) { scratch.Fill(i); }, query, normals,
      NormalSummer(index, query, normals),
      [&](size_t scale, size_t i, const LeafList& leaves) {
        SumHexagrams(index, plans[scale], leaves, i, largest, *s.scales[scale]);
      });
  if (!status.ok()) return status;
  for (size_t scale = 0; scale < plans.size(); ++scale) {
    AvgHexagramScratch& scratch = *s.scales[scale];
    MeasureHexagrams(scratch.hexagrams, plans[scale].rotations, scratch);
    WriteMeasured(index, plans[scale].neighborhood, UsualArea(plans[scale]), largest, scratch, results[scale]);
  }
  s.EndRun();
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <array>
#include <cmath>
#include <numbers>

#include "core/estimators/hexagram/avg_hexagram.h"
#include "core/estimators/scales/scales_run.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {

AvgHexagramPlan::AvgHexagramPlan(const EstimatorOptions& options, const SpatialIndex& index)
    : neighborhood(NeighborhoodPlan::Make(options, index)), rotations(static_cast<int>(options.rotation_count)) {
  // From the steepest on: the bounds divide the turn evenly, and one of them is vertical.
  for (int pair = 0; pair < BoundPairs(rotations); ++pair) {
    const double from_vertical = std::numbers::pi / 3.0 * (pair + 1) / rotations;
    cotangent[pair] = static_cast<float>(std::tan(from_vertical));
  }
}

size_t AvgHexagramScratch::MostBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t leaves = MostFoundLeaves(SearchSizes(options), point_count);
  return sizeof(AvgHexagramScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
         PointRows::MostBytes(leaves) + ScratchArray<int32_t>::MostBytes((leaves + 1) * SpatialIndex::kLeafSize);
}

namespace {

HWY_EXPORT(EstimateAvgHexagrams);
HWY_EXPORT(EstimateHexagramScales);

absl::Status EstimateGroup(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t group, AvgHexagramScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateAvgHexagrams)(index, plan, group, s, results);
}

absl::Status EstimateScales(const SpatialIndex& index, std::span<const AvgHexagramPlan> plans, size_t group,
                            ScalesScratch<AvgHexagramScratch>& s, std::span<PointCurvature* const> results) {
  return HWY_DYNAMIC_DISPATCH(EstimateHexagramScales)(index, plans, group, s, results);
}

constexpr std::array<OptionName, 1> kOptions = {"rotation_count"};

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t largest = AvgHexagramScratch::MostBytes(options, point_count);
  if (options.scale_count() == 1) return largest;
  return ScalesScratch<AvgHexagramScratch>::MostBytes(largest, sizeof(AvgHexagramScratch), options.scale_count());
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<AvgHexagramPlan, AvgHexagramScratch>>(index, AvgHexagramPlan(options, index),
                                                                               results, EstimateGroup);
}

std::unique_ptr<StrategyRun> StartScales(const EstimatorOptions& options, const SpatialIndex& index,
                                         std::span<PointCurvature* const> results) {
  const auto make_plan = [](const EstimatorOptions& scale, const SpatialIndex& of) {
    return AvgHexagramPlan(scale, of);
  };
  return std::make_unique<ScalesRun<AvgHexagramPlan, AvgHexagramScratch>>(options, index, results, make_plan,
                                                                          EstimateScales);
}

}  // namespace

extern const Strategy kAvgHexagram = {
    .name = "avg-hexagram",
    .wire_name = {},
    .summary = "two triangles over six sector averages, for each of rotation_count hexagrams",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = MostScratchBytes,
    .start = Start,
    .start_scales = StartScales};

}  // namespace curvd

#endif  // HWY_ONCE
