#include "core/job/strategy_phases.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/error.h"

namespace curvd {

const char* StrategyName(const EstimatorOptions& options) {
  constexpr const char* kNames[] = {"avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso"};
  return kNames[static_cast<size_t>(options.estimator)];
}

size_t StrategyBytesPerPoint(const EstimatorOptions& options) {
  return options.estimator == EstimatorKind::kDelaunay ? sizeof(Umbrella) : 0;
}

// Estimated from above: what a thread has for its group, the lists of leaves that a search keeps (half as many as
// neighbors and kListedLeaves more, core/estimators/group-inl.h), and the neighbors of one point.
size_t ScratchBytesPerWorker(const EstimatorOptions& options, size_t point_count) {
  constexpr size_t kGroupBytes = size_t{96} << 10, kListedLeaves = 192, kBytesPerLeaf = 512, kBytesPerNeighbor = 64;
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  const size_t neighbors = std::min<size_t>(count != nullptr ? count->count : options.max_neighbor_count, point_count);
  const size_t leaves = std::min(neighbors / 2 + kListedLeaves, SpatialIndex::LeafCount(point_count));
  return kGroupBytes + leaves * kBytesPerLeaf + neighbors * kBytesPerNeighbor;
}

StrategyRun::StrategyRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* points)
    : options_(options), index_(index), points_(points), plan_(EstimationPlan::Make(options, index)) {}

std::vector<GroupPhase> StrategyRun::phases() {
  std::vector<GroupPhase> phases;
  if (options_.estimator == EstimatorKind::kDelaunay) {
    phases.push_back({kUmbrellaPhase, [this] { return MakeUmbrellas(); },
                      [this](size_t group, GroupScratch& scratch) {
                        BuildUmbrellas(index_, umbrella_plan_, group, scratch, umbrellas_.data());
                        return absl::OkStatus();
                      }});
    phases.push_back({kUmbrellaPhase, nullptr, [this](size_t group, GroupScratch&) {
                        const size_t first = group * SpatialIndex::kGroupPoints;
                        const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.point_count());
                        CountOccurrences(umbrellas_.data(), first, last);
                        return absl::OkStatus();
                      }});
  }
  phases.push_back(
      {kEstimatePhase, nullptr, [this](size_t group, GroupScratch& scratch) { return Estimate(group, scratch); }});
  return phases;
}

absl::Status StrategyRun::MakeUmbrellas() {
  auto umbrellas = PageArray<Umbrella>::Create(index_.leaf_count() * SpatialIndex::kLeafSize);
  if (!umbrellas.ok()) return umbrellas.status();
  umbrellas_ = *std::move(umbrellas);
  umbrella_plan_ = EstimationPlan::ForUmbrellas(index_);
  plan_.umbrellas = umbrellas_.data();
  return absl::OkStatus();
}

absl::Status StrategyRun::Estimate(size_t group, GroupScratch& scratch) const {
  const OversizedNeighborhood oversized = EstimateGroup(index_, plan_, group, scratch, points_);
  if (oversized.point_id < 0) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kNeighborhoodTooLarge,
                       absl::StrFormat("radius %g gives point %d more than %u neighbors, the limit of this server; use "
                                       "a smaller radius, or neighbor_count",
                                       plan_.radius, oversized.point_id, options_.max_neighbor_count));
}

}  // namespace curvd
