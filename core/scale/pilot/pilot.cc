#include "core/scale/pilot/pilot.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/scale/pilot/rung_estimates.h"

namespace curvd {
namespace {

// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;

}  // namespace

Pilot::Pilot(const SpatialIndex& index, uint32_t most_count) : index_(index) {
  const size_t points = index.point_count();
  const size_t most = std::min<size_t>(most_count, std::max<size_t>(points / kLargestShare, kScaleRungs[0]));
  while (most_rungs_ < kRungCount && kScaleRungs[most_rungs_] <= std::min(most, points)) ++most_rungs_;
  if (most_rungs_ > 0) SetRungs(most_rungs_);
}

void Pilot::KeepMethods(const MethodSet& methods) {
  for (size_t m = 0; m < kMethodCount; ++m) {
    const bool tells_noise = m == kHexagramMethod || m == kRegressionMethod || m == kQuarticMethod;
    methods_[m] = methods_[m] && (methods[m] || tells_noise);
  }
}

void Pilot::SetRungs(size_t count) {
  rung_count_ = count;
  EstimatorOptions largest;
  largest.neighborhood = NeighborCount{kScaleRungs[rung_count_ - 1]};
  plan_ = NeighborhoodPlan::Make(largest, index_);
}

absl::Status Pilot::SampleGroup(size_t group, Samples which, PilotScratch& scratch, std::span<PilotPoint> table) const {
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index_.leaf_count());
  bool is_sampled = false;
  for (size_t leaf = first; leaf < last; ++leaf) is_sampled = is_sampled || IsSampledNow(leaf, which);
  if (!is_sampled) return absl::OkStatus();
  scratch.most_work = WorkerScratch::kNoLimit;  // the points are few
  scratch.first_point = 0;
  const auto leaf_of = [&](size_t i) { return static_cast<size_t>(scratch.points.place[i]) / SpatialIndex::kLeafSize; };
  // Where the points that are kept go in the table.
  std::array<size_t, SpatialIndex::kGroupPoints> places;
  std::array<size_t, SpatialIndex::kGroupLeaves> kept_of_leaf{};
  size_t kept = 0;
  const auto is_sampled_point = [&](size_t i) {
    const size_t leaf = leaf_of(i);
    size_t& rank = kept_of_leaf[leaf - first];
    if (rank == samples_of_leaf() || !IsSampledNow(leaf, which)) return false;
    places[kept++] = PlaceOf(leaf, which) + rank++;
    return true;
  };
  return CollectNeighbors(index_, plan_, group, CollectedPoints::kQueries, CollectedNormals::kOfHalves, scratch,
                          is_sampled_point, [&](size_t i) {
                            float position[3];
                            scratch.points.query.Get(i, position);
                            PilotPoint& point = table[places[i]];
                            point = PilotPoint({position[0], position[1], position[2]});
                            EstimateRungs(rung_count_, methods_, scratch, point);
                          });
}

}  // namespace curvd
