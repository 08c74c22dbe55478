#include "core/normals/trust/surface_probe.h"

#include <algorithm>

#include "core/normals/fits/fit_group.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

// Four points of each group are looked at. Of small clouds fewer, so that these take no longer than they must.
constexpr size_t kFewLookedAt = 16, kMostLookedAt = 32;
constexpr size_t kQuickCloud = 20'000;
size_t MostGroups(size_t point_count) { return point_count < kQuickCloud ? kFewLookedAt : kMostLookedAt; }
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestPlanarShare = 3;
// Neighbors lie near a plane if their variance across it is at most so much of the smaller one in it: noise of 0.35
// spacings makes as much of 16 of them, and of 0.6 spacings of 48; so does a fold of 60 degrees through the middle,
// either half of which is 30 degrees from the plane. They spread in it if the smaller variance in it is at least so
// much of the larger one.
constexpr double kMostAcross = 0.1, kLeastPlaneBreadth = 0.1;
// The square of the cosine of 30 degrees.
constexpr double kLeastSquaredCosine = 0.75;
// From so many points on planes on, and such a share of all, these tell.
constexpr uint32_t kFewestOnPlanes = 16;
constexpr double kLeastOnPlanes = 0.25;

uint32_t MostAmong(size_t point_count, uint32_t max_neighbor_count) {
  return static_cast<uint32_t>(std::min<size_t>(point_count / kLargestPlanarShare, max_neighbor_count));
}

}  // namespace

SurfaceProbe::SurfaceProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index), groups_(SampleGroups(index, MostGroups(index.point_count()))), scratch_(thread_count) {
  for (const uint32_t count : kLadder) {
    if (count <= MostAmong(index.point_count(), max_neighbor_count)) plans_.emplace_back(PlaneFit(count), index);
  }
}

// Larger neighborhoods would take the steps of stairs for a slope.
bool SurfaceProbe::AddBlocks() {
  if (Tells() || looked_at_ == plans_.size()) return false;
  ++looked_at_;
  return true;
}

bool SurfaceProbe::Tells() const {
  if (looked_at_ == 0) return false;
  const Tally& last = tallies_[looked_at_ - 1];
  return last.on_planes >= std::max<double>(kFewestOnPlanes, kLeastOnPlanes * last.points);
}

absl::Status SurfaceProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  const size_t rung = looked_at_ - 1, first = block * kGroupsPerBlock;
  for (size_t i = first; i < std::min(first + kGroupsPerBlock, groups_.size()); ++i) {
    const absl::Status status = FitGroup(index_, plans_[rung], groups_[i], GroupSample::kOneOfEachLeaf, scratch);
    if (!status.ok()) return status;
    for (size_t point = 0; point < scratch.points.size; ++point) Take(point, scratch, tallies_[rung]);
  }
  return absl::OkStatus();
}

void SurfaceProbe::Take(size_t i, const NormalScratch& s, Tally& tally) const {
  ++tally.points;
  if (s.points.status[i] != PointStatus::kOk) return;
  if (!(s.variance_ratio[i] <= kMostAcross && s.breadth[i] >= kLeastPlaneBreadth)) return;
  const auto place = static_cast<size_t>(s.points.place[i]);
  const SpatialIndex::LeafNormals& given = index_.normals(place / SpatialIndex::kLeafSize);
  const size_t lane = place % SpatialIndex::kLeafSize;
  const double cosine = given.x[lane] * s.normal.x[i] + given.y[lane] * s.normal.y[i] + given.z[lane] * s.normal.z[i];
  ++tally.on_planes;
  tally.off += cosine * cosine < kLeastSquaredCosine ? 1 : 0;
}

std::optional<NormalsOffSurface> SurfaceProbe::found() const {
  if (!Tells()) return std::nullopt;
  const Tally& last = tallies_[looked_at_ - 1];
  return NormalsOffSurface{last.on_planes, last.off};
}

size_t SurfaceProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count) {
  const uint32_t most = MostAmong(point_count, max_neighbor_count);
  if (most < kLadder.front()) return 0;
  return std::min(static_cast<size_t>(thread_count), MostGroups(point_count) / kGroupsPerBlock) *
         NormalScratch::MostBytes(PlaneFit(std::min(most, kLadder.back())), point_count);
}

}  // namespace curvd
