#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/hexagram/avg_hexagram.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/hexagram/hexagram-inl.h"
#include "core/estimators/hexagram/sector_sums-inl.h"
#include "core/estimators/principal-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Area of the two triangles of a hexagram over a neighborhood that fills a disc, in units of rho^2.
inline constexpr float kUsualAveragedArea = 1.05f;

absl::Status EstimateAvgHexagrams(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t group,
                                  AvgHexagramScratch& s, PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) SumHexagrams(index, plan, leaves, i, s);
  };
  const absl::Status status = ForEachNormalSum(index, plan.neighborhood, s, sum);
  if (!status.ok()) return status;
  MeasureHexagrams(s.hexagrams, plan.rotations, s);
  WriteMeasured(index, plan.neighborhood, static_cast<float>(plan.rotations) * kUsualAveragedArea, s, results);
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
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {

AvgHexagramPlan::AvgHexagramPlan(const EstimatorOptions& options, const SpatialIndex& index)
    : neighborhood(NeighborhoodPlan::Make(options, index)), rotations(static_cast<int>(options.rotation_count)) {
  for (int r = 0; r < rotations; ++r) {
    const double angle = std::numbers::pi / 3.0 * r / rotations;
    cosine[r] = static_cast<float>(std::cos(angle));
    sine[r] = static_cast<float>(std::sin(angle));
  }
}

size_t AvgHexagramScratch::MostBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t leaves = MostFoundLeaves(SearchSizes(options), point_count);
  return sizeof(AvgHexagramScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
         PointRows::MostBytes(leaves) + ScratchArray<int32_t>::MostBytes((leaves + 1) * SpatialIndex::kLeafSize);
}

namespace {

HWY_EXPORT(EstimateAvgHexagrams);

absl::Status EstimateGroup(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t group, AvgHexagramScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateAvgHexagrams)(index, plan, group, s, results);
}

constexpr std::array<OptionName, 1> kOptions = {"rotation_count"};

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<AvgHexagramPlan, AvgHexagramScratch>>(index, AvgHexagramPlan(options, index),
                                                                               results, EstimateGroup);
}

}  // namespace

extern const Strategy kAvgHexagram = {
    .name = "avg-hexagram",
    .wire_name = {},
    .summary = "two triangles over six sector averages, for each of rotation_count hexagrams",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = 0,
    .scratch_bytes = AvgHexagramScratch::MostBytes,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
