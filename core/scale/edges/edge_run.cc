#include "core/scale/edges/edge_run.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/copies.h"
#include "core/estimators/neighbors/collect.h"
#include "core/scale/edges/normal_faces.h"
#include "core/scale/pilot/pilot.h"
#include "core/scale/point_fits/field_curvature.h"
#include "core/scale/point_fits/sorted_normals.h"

namespace curvd {
namespace {

// Neighbors whose normals tell an edge.
constexpr uint32_t kMeasured = 32;
// Samples around a group that tell what is usual there, and the share of them which is no rougher: edges are few.
constexpr size_t kNearestSamples = 24;
constexpr double kNoRougherShare = 0.4;
// Where fewer of the points whose normals are rough than this share lie beside edges, it is detail that makes them so:
// it is to be kept, and edges cannot be told from it.
constexpr double kLeastEdgeShare = 0.5;
// The same where the positions have shown that there are edges (SpatialIndex::shows_edges). Normals were then made of
// so many neighbors on the faces that even those are rough beside them which are a few spacings from an edge and bent
// by it, and have not the normals of two faces. Measured on noisy solids: 0.15 to 0.9.
constexpr double kLeastShareOfShownEdges = 0.1;

// Whether a point is measured in any case: a quarter of each leaf's. The others are where one of these in their group
// may be rough: an edge has several points to either side.
bool IsMeasuredFirst(size_t place) { return place % 4 == 0; }

NeighborhoodPlan PlanFor(uint32_t count, const SpatialIndex& index) {
  EstimatorOptions options;
  options.neighborhood = NeighborCount{count};
  return NeighborhoodPlan::Make(options, index);
}

// Where fewer of the neighbors than this share have positions of their own, they are too few to tell faces from noise.
constexpr double kLeastDistinctShare = 0.5;

// Leaves one neighbor of those that are copies of each other: they share their noise, and look like a face.
void DropCopies(std::vector<NeighborNormal>& neighbors) {
  double farthest = 0.0;
  for (const NeighborNormal& neighbor : neighbors) farthest = std::max(farthest, neighbor.offset.squaredNorm());
  const auto squared = [&](size_t i, size_t j) { return (neighbors[i].offset - neighbors[j].offset).squaredNorm(); };
  NearCopies copies(static_cast<float>(std::sqrt(farthest)), neighbors.size());
  for (size_t i = 0; i < neighbors.size(); ++i) {
    for (size_t j = 0; j < i; ++j) copies.AddPair(static_cast<float>(squared(i, j)));
  }
  const double most = copies.Exist() ? copies.distance() * copies.distance() : 0.0;
  size_t kept = 0;
  for (size_t i = 0; i < neighbors.size(); ++i) {
    bool is_copy = false;
    for (size_t j = 0; j < kept; ++j) is_copy = is_copy || squared(i, j) <= most;
    if (!is_copy) neighbors[kept++] = neighbors[i];
  }
  neighbors.resize(kept);
}

// The neighbors that were collected, as they come.
void CopyNeighbors(const PilotScratch& s, std::vector<NeighborNormal>& neighbors) {
  const NeighborArrays& n = s.neighbors;
  neighbors.clear();
  for (size_t j = 0; j < n.count; ++j) {
    neighbors.push_back({Eigen::Vector3d(n.dx[j], n.dy[j], n.dz[j]), Eigen::Vector3d(n.nx[j], n.ny[j], n.nz[j])});
  }
}

}  // namespace

EdgeRun::EdgeRun(const SpatialIndex& index)
    : index_(index), is_large_enough_(index.point_count() >= size_t{3} * kMeasured), marks_(index) {
  if (is_large_enough_) measured_ = PlanFor(kMeasured, index);
}

void EdgeRun::LookAmong(uint32_t count) {
  const uint32_t most = static_cast<uint32_t>(std::min<size_t>(index_.point_count() / 3, count));
  if (is_large_enough_) repaired_ = PlanFor(most, index_);
}

absl::Status EdgeRun::MeasureTrends(size_t group, absl::FunctionRef<bool(size_t place)> keep, PilotScratch& s) {
  const auto place_of = [&s](size_t i) { return static_cast<size_t>(s.points.place[i]); };
  const auto keep_at = [&](size_t i) { return keep(place_of(i)); };
  return CollectNeighbors(index_, measured_, group, CollectedPoints::kAll, CollectedNormals::kInUse, s, keep_at,
                          [&](size_t i) {
                            s.search.work += 16 * s.neighbors.count;
                            CopyNeighbors(s, s.normals);
                            marks_.SetTrend(place_of(i), TrendOf(s.normals));
                          });
}

absl::Status EdgeRun::Measure(size_t group, PilotScratch& s) {
  if (!is_large_enough_) return absl::OkStatus();
  s.rest = 0;
  const absl::Status status = MeasureTrends(group, IsMeasuredFirst, s);
  s.LeaveRestAfterLast(group);
  return status;
}

void EdgeRun::Sample(double position_noise) {
  position_noise_ = position_noise;
  const size_t leaves = index_.leaf_count(), count = std::min(leaves, Pilot::kMostPoints);
  for (size_t k = 0; k < count; ++k) {
    const size_t leaf = k * leaves / count;
    const SpatialIndex::LeafPositions& points = index_.positions(leaf);
    const float roughness = marks_.RoughnessAt(leaf * SpatialIndex::kLeafSize);
    if (std::isfinite(roughness)) samples_.push_back({{points.x[0], points.y[0], points.z[0]}, roughness});
  }
}

double EdgeRun::NoiseAround(size_t group) const {
  const SpatialIndex::LeafPositions& points = index_.positions(group * SpatialIndex::kGroupLeaves);
  std::array<std::pair<float, float>, Pilot::kMostPoints> near;  // squared distance, roughness
  size_t count = 0;
  for (const Sampled& sample : samples_) {
    const float x = sample.position[0] - points.x[0], y = sample.position[1] - points.y[0],
                z = sample.position[2] - points.z[0];
    near[count++] = {x * x + y * y + z * z, sample.roughness};
  }
  const size_t kept = std::min(count, kNearestSamples);
  if (kept == 0) return std::numeric_limits<double>::infinity();
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept),
                    near.begin() + static_cast<std::ptrdiff_t>(count));
  const auto usual = near.begin() + static_cast<std::ptrdiff_t>(kNoRougherShare * static_cast<double>(kept - 1));
  std::nth_element(near.begin(), usual, near.begin() + static_cast<std::ptrdiff_t>(kept),
                   [](const auto& a, const auto& b) { return a.second < b.second; });
  return usual->second;
}

// Whose normals are of faces is looked at here, and not while trends are measured: few points are rougher than noise.
absl::Status EdgeRun::Mark(size_t group, PilotScratch& s) {
  if (!is_large_enough_) return absl::OkStatus();
  const size_t first = group * SpatialIndex::kGroupPoints;
  const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.leaf_count() * SpatialIndex::kLeafSize);
  const auto any_may_be_rough = [&](const EdgeNoise& noise) {
    for (size_t place = first; place < last; ++place) {
      if (marks_.MayBeRough(place, noise)) return true;
    }
    return false;
  };
  // Exact normals need not be compared with what is usual.
  if (!any_may_be_rough({0.0, 0.0})) return absl::OkStatus();
  const EdgeNoise noise{NoiseAround(group), position_noise_};
  if (!any_may_be_rough(noise)) return absl::OkStatus();
  s.first_point = 0;
  s.most_work = WorkerScratch::kNoLimit;  // a group's points are few
  const auto is_left = [](size_t place) { return !IsMeasuredFirst(place); };
  if (absl::Status status = MeasureTrends(group, is_left, s); !status.ok()) return status;
  size_t rough = 0;
  for (size_t place = first; place < last; ++place) rough += marks_.IsRough(place, noise) ? 1 : 0;
  if (rough == 0) return absl::OkStatus();
  uint64_t has_faces = 0;
  const auto place_of = [&s](size_t i) { return static_cast<size_t>(s.points.place[i]); };
  const auto is_rough = [&](size_t i) { return marks_.IsRough(place_of(i), noise); };
  const absl::Status status = CollectNeighbors(
      index_, measured_, group, CollectedPoints::kAll, CollectedNormals::kInUse, s, is_rough, [&](size_t i) {
        s.search.work += 16 * s.neighbors.count;
        CopyNeighbors(s, s.normals);
        DropCopies(s.normals);
        if (static_cast<double>(s.normals.size()) < kLeastDistinctShare * kMeasured) return;
        if (AreOfBend(s.normals)) {
          --rough;
        } else if (AreOfFaces(SpreadOf(s.normals), marks_.NoiseAt(place_of(i), noise))) {
          has_faces |= uint64_t{1} << (place_of(i) - first);
        }
      });
  if (status.ok()) marks_.MarkGroup(group, rough, has_faces);
  return status;
}

void EdgeRun::Finish() {
  if (is_large_enough_) marks_.Finish();
}

bool EdgeRun::HasEdges() const {
  const double least_share = index_.shows_edges() ? kLeastShareOfShownEdges : kLeastEdgeShare;
  return marks_.HasEdges() &&
         static_cast<double>(marks_.edge_count()) >= least_share * static_cast<double>(marks_.rough_count());
}

void EdgeRun::KeepClear(PilotTable& table) const {
  if (!HasEdges()) return;
  for (PilotPoint& point : table) {
    const float distance = DistanceToEdge(point.position.data());
    size_t clear = 0;
    while (clear < kRungCount && point.radius[clear] < distance) ++clear;
    point.KeepClear(clear);
  }
}

float EdgeRun::DistanceToEdge(const float* position) const {
  if (!HasEdges()) return std::numeric_limits<float>::infinity();
  return std::sqrt(marks_.SquaredDistance(position, std::numeric_limits<float>::max()));
}

absl::Status EdgeRun::Repair(size_t group, float most_radius, absl::FunctionRef<bool(size_t i)> is_one_sided,
                             absl::FunctionRef<OneSideScale(const float* position)> scale_at,
                             absl::FunctionRef<void(size_t n, const PointFit& estimate)> take, PilotScratch& s) const {
  const double normal_noise = NoiseAround(group), to_caller = std::ldexp(1.0, index_.scale_exponent());
  s.most_work = WorkerScratch::kNoLimit;  // a group's points are few
  return CollectNeighbors(
      index_, repaired_, group, CollectedPoints::kQueries, CollectedNormals::kInUse, s, is_one_sided, [&](size_t i) {
        s.search.work += 16 * s.neighbors.count;
        float position[3], normal[3];
        s.points.query.Get(i, position);
        s.points.normal.Get(i, normal);
        SortNormals(most_radius, s);
        const OneSideScale scale = scale_at(position);
        const auto found =
            EstimateOneSide(s.normals, Eigen::Vector3d(normal[0], normal[1], normal[2]),
                            {scale.count, normal_noise, position_noise_, scale.allowed_error, scale.least_count});
        if (!found.has_value()) return;
        if (const auto scaled = Scaled(*found, to_caller)) take(i, *scaled);
      });
}

}  // namespace curvd
