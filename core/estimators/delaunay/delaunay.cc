#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/delaunay/delaunay.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/delaunay/umbrella_triangles-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/principal-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Area that triangles cover, in units of rho^2, where neighbors fill a disc.
inline constexpr float kDiscArea = 3.14f;

absl::Status EstimateDelaunay(const SpatialIndex& index, const DelaunayPlan& plan, size_t group, DelaunayScratch& s,
                              PointCurvature* results) {
  const auto fill = [&s](size_t i) { s.measures.Fill(i); };
  StartGroup(index, group, s, results, fill);
  const auto measure = [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (s.points.status[i] == PointStatus::kOk) MeasureUmbrellas(index, plan, leaves, i, s);
  };
  const absl::Status status = ForEachNormalSum(index, plan.neighborhood, s, measure);
  if (status.ok())
    WriteMeasured(index, plan.neighborhood, kDiscArea * (1.0f - 0.5f * static_cast<float>(plan.falloff)), s, s,
                  results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/page_array.h"
#include "core/estimators/delaunay/delaunay_scratch.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(EstimateDelaunay);

constexpr std::array<OptionName, 1> kOptions = {"even_weights"};

// Umbrellas of all points, then in how many of them each triangle occurs, then the estimates.
class DelaunayRun final : public StrategyRun {
 public:
  DelaunayRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* results)
      : index_(index), plan_(options, index), umbrella_search_(UmbrellaSearch(index)), results_(results) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<DelaunayScratch>(); }
  size_t bytes() const override { return umbrellas_.bytes(); }

  std::vector<GroupPhase> Phases() override {
    return {{"umbrellas", [this] { return Allocate(); },
             [this](size_t group, WorkerScratch& scratch) {
               BuildUmbrellas(index_, umbrella_search_, group, static_cast<DelaunayScratch&>(scratch),
                              umbrellas_.data());
               return absl::OkStatus();
             }},
            {"umbrellas", nullptr,
             [this](size_t group, WorkerScratch&) {
               const size_t first = group * SpatialIndex::kGroupPoints;
               CountOccurrences(umbrellas_.data(), first,
                                std::min(first + SpatialIndex::kGroupPoints, index_.point_count()));
               return absl::OkStatus();
             }},
            {"curvature", nullptr, [this](size_t group, WorkerScratch& scratch) {
               return HWY_DYNAMIC_DISPATCH(EstimateDelaunay)(index_, plan_, group,
                                                             static_cast<DelaunayScratch&>(scratch), results_);
             }}};
  }

 private:
  absl::Status Allocate() {
    auto umbrellas = PageArray<Umbrella>::Create(index_.leaf_count() * SpatialIndex::kLeafSize);
    if (!umbrellas.ok()) return umbrellas.status();
    umbrellas_ = *std::move(umbrellas);
    plan_.umbrellas = umbrellas_.data();
    return absl::OkStatus();
  }

  const SpatialIndex& index_;
  DelaunayPlan plan_;
  const SearchPlan umbrella_search_;
  PointCurvature* const results_;
  PageArray<Umbrella> umbrellas_;
};

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  const SearchPlan search = SearchSizes(options), umbrella_search = SearchPlan::ByCount(kUmbrellaNeighbors + 1);
  const size_t leaves = MostFoundLeaves(search, point_count);
  return sizeof(DelaunayScratch) + SearchScratchBytes(search, point_count) +
         SearchScratchBytes(umbrella_search, point_count) + UmbrellaTriangles::MostBytes(leaves) +
         ScratchArray<uint32_t>::MostBytes(leaves);
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<DelaunayRun>(options, index, results);
}

}  // namespace

extern const Strategy kDelaunay = {
    .name = "delaunay",
    .wire_name = {},
    .summary = "the triangles of local Delaunay umbrellas with all corners in the neighborhood",
    .options = kOptions,
    .needs_normals = true,
    .bytes_per_point = sizeof(Umbrella),
    .scratch_bytes = MostScratchBytes,
    // A neighbor's umbrella is made of its nearest points. The ball of twice the radius around it holds the whole
    // neighborhood, hence all of those.
    .reach_factor = 3.0,
    .least_bounded_count = kUmbrellaNeighbors + 1,
    .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
