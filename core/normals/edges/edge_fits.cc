#include "core/normals/edges/edge_fits.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <variant>

#include "core/base/halves.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/runs/half_normals.h"

namespace curvd {
namespace {

// Points of a group, a bit for each place.
using GroupPlaces = uint64_t;
static_assert(SpatialIndex::kGroupPoints == 64);

size_t PlaceInGroup(const GroupPoints& points, size_t i) {
  return static_cast<size_t>(points.place[i]) % SpatialIndex::kGroupPoints;
}

GroupPlaces PlacesOf(const GroupPoints& points) {
  GroupPlaces places = 0;
  for (size_t i = 0; i < points.size; ++i) places |= GroupPlaces{1} << PlaceInGroup(points, i);
  return places;
}

GroupPlaces PlacesOfHalf(const SpatialIndex& index, size_t group, Half half) {
  GroupPlaces places = 0;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  for (size_t leaf = first; leaf < last; ++leaf) {
    for (size_t lane = 0; lane < static_cast<size_t>(index.LeafPoints(leaf)); ++lane) {
      if (HalfOf(index.positions(leaf).id[lane]) != half) continue;
      places |= GroupPlaces{1} << ((leaf - first) * SpatialIndex::kLeafSize + lane);
    }
  }
  return places;
}

// Those points of the scratch whose neighborhoods lie on one side, as what their fits leave of the heights tells.
GroupPlaces PlacesOnOneSide(const NormalScratch& s, double most) {
  GroupPlaces places = 0;
  for (size_t i = 0; i < s.points.size; ++i) {
    const double rho = s.frames.rho[i];
    if (s.points.status[i] != PointStatus::kOk || !(s.mean_square[i] * rho * rho <= most)) continue;
    places |= GroupPlaces{1} << PlaceInGroup(s.points, i);
  }
  return places;
}

// Copies what the scratch has of these points to `fits`, which has them among its members. Both are in the order of
// the places.
void CopyFits(const NormalScratch& s, GroupPlaces which, SharedFits& fits) {
  size_t to = 0;
  for (size_t i = 0; i < s.points.size; ++i) {
    if ((which >> PlaceInGroup(s.points, i) & 1) == 0) continue;
    while (fits.members.place[to] != s.points.place[i]) ++to;
    fits.members.status[to] = s.points.status[i];
    const double normal[3] = {s.normal.x[i], s.normal.y[i], s.normal.z[i]};
    fits.normal.Set(to, normal);
    fits.mean_square[to] = s.mean_square[i];
    fits.variance_ratio[to] = s.variance_ratio[i];
  }
}

absl::Status FitPlaces(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupPlaces which,
                       GroupSample sample, NormalScratch& s) {
  s.chosen = which;
  absl::Status status = FitChosen(index, plan, group, sample, s);
  s.chosen = NormalScratch::kAllOfGroup;
  return status;
}

// Fits each point by the first rung that is for it, and tells which points each rung is for. A run that ends early does
// so in the first rung; the others are for points of that one.
absl::Status FitByRungs(const SpatialIndex& index, const EdgePlan& edges, size_t group, GroupPlaces left,
                        GroupSample sample, NormalScratch& s, std::vector<GroupPlaces>& places_of_rung) {
  const uint64_t most_work = s.most_work;
  s.shared.members.size = 0;
  absl::Status status = absl::OkStatus();
  for (size_t rung = 0; rung < edges.rungs.size() && left != 0 && status.ok(); ++rung) {
    status = FitPlaces(index, edges.rungs[rung], group, left, sample, s);
    if (!status.ok()) break;
    if (rung == 0) {
      s.shared.members = s.points;
      left = PlacesOf(s.points);
      s.most_work = std::numeric_limits<uint64_t>::max();
    }
    const bool is_last = rung + 1 == edges.rungs.size();
    places_of_rung[rung] = is_last ? left : left & PlacesOnOneSide(s, edges.most[rung]);
    CopyFits(s, places_of_rung[rung], s.shared);
    left &= ~places_of_rung[rung];
  }
  s.most_work = most_work;
  return status;
}

// Fits those points to their half, each by its rung. Those of a last rung that has too few neighbors for that keep the
// fits that they have.
absl::Status FitHalves(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                       const std::vector<GroupPlaces>& places_of_rung, NormalScratch& s) {
  const EdgePlan& edges = *plan.edges;
  const uint64_t most_work = std::exchange(s.most_work, std::numeric_limits<uint64_t>::max());
  absl::Status status = absl::OkStatus();
  const size_t rungs = edges.rungs.size() - (edges.last_has_halves ? 0 : 1);
  for (size_t rung = 0; rung < rungs && status.ok(); ++rung) {
    if (places_of_rung[rung] == 0) continue;
    NormalPlan of_half = edges.rungs[rung];
    of_half.half = plan.half;
    status = FitPlaces(index, of_half, group, places_of_rung[rung], sample, s);
    if (status.ok()) CopyFits(s, places_of_rung[rung], s.shared);
  }
  s.most_work = most_work;
  return status;
}

}  // namespace

EdgePlan PlanEdges(const NormalFit& fit, const SpatialIndex& index) {
  const EdgePart& part = *fit.edge_part;
  EdgePlan plan{};
  NormalFit rung = fit;
  rung.edge_part.reset();
  rung.half.reset();
  const uint32_t coefficients = static_cast<uint32_t>(JetSize(std::max(JetDegree(fit.method), 1)));
  const uint32_t least_of_halves = LeastNeighborCountOfHalves(fit.method);
  const uint32_t least = std::max(2 * part.neighborhood.count, least_of_halves);
  for (uint32_t count = std::get<NeighborCount>(fit.neighborhood).count;; count /= 2) {
    if (count < least) count = part.neighborhood.count;
    rung.neighborhood = NeighborCount{count};
    plan.rungs.push_back(NormalPlan(rung, index));
    const double freedom = std::max(static_cast<double>(count) - coefficients, 1.0);
    plan.most.push_back(part.variance * EdgePart::MostOfNoise(freedom) * freedom / count);
    if (count == part.neighborhood.count) break;
  }
  plan.last_has_halves = part.neighborhood.count >= least_of_halves;
  return plan;
}

absl::Status FitBesideEdges(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                            NormalScratch& scratch) {
  std::vector<GroupPlaces> places_of_rung(plan.edges->rungs.size(), 0);
  const GroupPlaces all = plan.half.has_value() ? PlacesOfHalf(index, group, *plan.half) : NormalScratch::kAllOfGroup;
  absl::Status status = FitByRungs(index, *plan.edges, group, all, sample, scratch, places_of_rung);
  if (status.ok() && plan.half.has_value()) {
    status = FitHalves(index, plan, group, sample, places_of_rung, scratch);
  }
  if (!status.ok()) return status;
  scratch.points = scratch.shared.members;
  scratch.normal = scratch.shared.normal;
  std::copy_n(scratch.shared.mean_square, scratch.points.size, scratch.mean_square);
  std::copy_n(scratch.shared.variance_ratio, scratch.points.size, scratch.variance_ratio);
  return status;
}

}  // namespace curvd
