#include "core/normals/trust/plane_probe.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/normals/fits/fit_group.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

constexpr size_t kFewProbedGroups = 8, kMostProbedGroups = 64;
// Planes have so many neighbors at least, and fewer than so many.
constexpr uint32_t kFewestOfPlanes = 5, kMostOfPlanes = 800;
// Halves of 12 neighbors say too little of what noise does to planes of fewer than so many.
constexpr uint32_t kFewestFound = 10;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestPartOfPlanes = 2;
// What rounding of positions may turn planes of the radius 1 by, squared: on a grid, many of them have the exact normal
// by symmetry, and one of these is the nearest by chance.
constexpr double kSquaredRounding = 0x1p-44;
// Between quartiles of the numbers of neighbors within one radius: halves are made of one number.
constexpr uint32_t kMostSpreadOfCounts = 2;
// Of two spreads of points across the normal, the product over the square of their mean: 1 in a disc, 0 on a line.
constexpr double kLeastSpread = 0.05;
// Of the few samples so many have to be those of planes, or the others are not looked at. Measured: 0.07 at
// most of other normals, on the 65 clouds that the tests have.
constexpr double kLeastOfFew = 0.15;

uint32_t MostOfPlanes(size_t point_count, uint32_t max_neighbor_count) {
  const size_t most = std::min<size_t>(point_count / kLargestPartOfPlanes, max_neighbor_count);
  return static_cast<uint32_t>(std::clamp<size_t>(most, 1, kMostOfPlanes));
}

bool HasPlanes(size_t point_count, uint32_t max_neighbor_count) {
  return MostOfPlanes(point_count, max_neighbor_count) >= 2 * kFewestOfPlanes;
}

struct Neighbor {
  float squared_distance;
  uint32_t place;
};

// Sums over neighbors, one by one, and how far a normal is from that of their plane.
class PlaneSums {
 public:
  explicit PlaneSums(const Eigen::Vector3d& normal) : normal_(normal) {}

  void Add(const Eigen::Vector3d& offset) {
    sum_ += offset;
    products_.noalias() += offset * offset.transpose();
    ++count_;
  }

  // The squared angle, which is small: a unit vector n is an eigenvector of the covariance C if C n is along n, and
  // else C n has a part across it that grows with the angle and the difference of eigenvalues. Infinity where the
  // neighbors do not spread clearly more in each direction across the normal than along it.
  double SquaredDifference() const {
    const Eigen::Vector3d mean = sum_ / count_;
    const Eigen::Matrix3d covariance = products_ / count_ - mean * mean.transpose();
    const Eigen::Vector3d image = covariance * normal_;
    const double along = normal_.dot(image), trace = covariance.trace();
    // With n an eigenvector, those of the other two eigenvalues beyond that of n: their sum, halved, and product.
    const double gap = 0.5 * (trace - along) - along;
    const double pairs = 0.5 * (trace * trace - covariance.squaredNorm());  // sum of the products of two eigenvalues
    const double product = pairs - 2.0 * along * (trace - along) + along * along;
    if (!(gap > 0.0 && product > kLeastSpread * gap * gap)) return std::numeric_limits<double>::infinity();
    return std::max(image.squaredNorm() - along * along, 0.0) / (gap * gap);
  }

 private:
  const Eigen::Vector3d normal_;
  double count_ = 0.0;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products_ = Eigen::Matrix3d::Zero();
};

}  // namespace

PlaneProbe::PlaneProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index),
      plan_(PlaneFit(MostOfPlanes(index.point_count(), max_neighbor_count)), index),
      scratch_(thread_count) {
  if (!HasPlanes(index.point_count(), max_neighbor_count)) stage_ = Stage::kDone;
}

bool PlaneProbe::AddBlocks() {
  switch (stage_) {
    case Stage::kNone:
      stage_ = Stage::kFew;
      LookAt(kFewProbedGroups);
      return true;
    case Stage::kFew: {
      const auto matched = std::count_if(matches_.begin(), matches_.end(), [](const Match& m) { return m.count > 0; });
      if (static_cast<double>(matched) < kLeastOfFew * static_cast<double>(std::max<size_t>(KnownCount(), 1))) break;
      stage_ = Stage::kAll;
      LookAt(kMostProbedGroups);
      return true;
    }
    case Stage::kAll:
      Find();
      break;
    case Stage::kDone:
      break;
  }
  stage_ = Stage::kDone;
  return false;
}

void PlaneProbe::LookAt(size_t group_count) {
  groups_ = SampleGroups(index_, group_count);
  matches_.assign(groups_.size() * SpatialIndex::kGroupLeaves, Match{});
}

absl::Status PlaneProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  Match* const matches = &matches_[block * SpatialIndex::kGroupLeaves];
  scratch.inspect = [this, &s = scratch, matches](size_t i) { matches[i] = MatchOf(s, i, index_); };
  return FitGroup(index_, plan_, groups_[block], GroupSample::kOneOfEachLeaf, scratch);
}

PlaneProbe::Match PlaneProbe::MatchOf(const NormalScratch& s, size_t i, const SpatialIndex& index) {
  const auto place = static_cast<size_t>(s.points.place[i]);
  const SpatialIndex::LeafNormals& normals = index.normals(place / SpatialIndex::kLeafSize);
  const size_t lane = place % SpatialIndex::kLeafSize;
  Match match;
  if (std::isnan(normals.x[lane])) return match;
  std::array<Neighbor, kMostOfPlanes> sorted;
  const auto neighbor_count = static_cast<uint32_t>(std::min<size_t>(s.neighbors.count, kMostOfPlanes));
  const float *const x = s.neighbors.dx.data(), *const y = s.neighbors.dy.data(), *const z = s.neighbors.dz.data();
  for (uint32_t j = 0; j < neighbor_count; ++j) sorted[j] = {x[j] * x[j] + y[j] * y[j] + z[j] * z[j], j};
  // In an order that does not depend on that of the neighbors, which differs between instruction sets.
  const auto rank = [&](const Neighbor& n) { return std::tie(n.squared_distance, x[n.place], y[n.place], z[n.place]); };
  std::sort(sorted.begin(), sorted.begin() + neighbor_count,
            [&](const Neighbor& a, const Neighbor& b) { return rank(a) < rank(b); });

  PlaneSums sums(Eigen::Vector3d{normals.x[lane], normals.y[lane], normals.z[lane]});
  FitMatch least;
  std::array<double, kMostOfPlanes> differences;  // by the number of neighbors
  differences.fill(std::numeric_limits<double>::infinity());
  for (uint32_t count = 1; count < neighbor_count; ++count) {
    const uint32_t j = sorted[count - 1].place;
    sums.Add({x[j], y[j], z[j]});
    if (count < kFewestOfPlanes) continue;
    differences[count] = sums.SquaredDifference() + kSquaredRounding / sorted[count - 1].squared_distance;
    least.Take(count, differences[count]);
  }
  match.is_known = least.is_known();
  match.count = least.count();
  if (match.count == 0) return match;
  // A plane across which the normal does not lie is far from it.
  const auto difference_of = [&](uint32_t count) {
    return count < neighbor_count ? std::min(differences[count], 1.0) : std::numeric_limits<double>::infinity();
  };
  match.sample = {least.least_of_others(), difference_of(match.count / 2), difference_of(2 * match.count)};
  match.farthest = sorted[match.count - 1].squared_distance;
  match.next = sorted[match.count].squared_distance;
  return match;
}

size_t PlaneProbe::KnownCount() const {
  return static_cast<size_t>(
      std::count_if(matches_.begin(), matches_.end(), [](const Match& match) { return match.is_known; }));
}

std::pair<uint32_t, FitAgreement> PlaneProbe::OfOneCount() const {
  FitVotes votes;
  for (const Match& match : matches_) votes.Add(match.is_known, match.count, match.sample);
  return votes.Most();
}

std::pair<uint32_t, FitAgreement> PlaneProbe::OfOneRadius() const {
  // Where radii become large enough for a match, and where they become too large: of radii that are equal, the latter
  // come first.
  std::vector<std::pair<float, int>> bounds;
  for (const Match& match : matches_) {
    if (match.count == 0 || match.farthest == match.next) continue;
    bounds.emplace_back(match.farthest, 1);
    bounds.emplace_back(match.next, -1);
  }
  std::sort(bounds.begin(), bounds.end());
  int within = 0, most_within = 0;
  float radius = 0.0f;
  for (const auto& [squared_radius, change] : bounds) {
    within += change;
    if (within <= most_within) continue;
    most_within = within;
    radius = squared_radius;
  }
  std::vector<uint32_t> counts;
  std::pair<uint32_t, FitAgreement> agreement;
  for (const Match& match : matches_) {
    if (match.count == 0 || match.farthest > radius || match.next <= radius) continue;
    counts.push_back(match.count);
    agreement.second.Add(match.sample);
  }
  if (counts.empty()) return {};
  std::sort(counts.begin(), counts.end());
  if (counts[counts.size() * 3 / 4] > kMostSpreadOfCounts * counts[counts.size() / 4]) return {};
  agreement.first = counts[counts.size() / 2];
  return agreement;
}

void PlaneProbe::Find() {
  auto most = OfOneCount(), of_radius = OfOneRadius();
  if (of_radius.second.size() > most.second.size()) most = std::move(of_radius);
  if (!most.second.IsEnough(KnownCount())) return;
  found_ = FoundFit{{NormalMethod::kPca, most.first}, std::nullopt};
  if (most.first < kFewestFound || !most.second.IsMadeByNoise()) return;
  found_->of_halves = PlaneFit(std::max(most.first, LeastNeighborCountOfHalves(NormalMethod::kPca)));
}

size_t PlaneProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  if (!HasPlanes(point_count, max_neighbor_count)) return 0;
  return NormalScratch::MostBytes(PlaneFit(MostOfPlanes(point_count, max_neighbor_count)), point_count);
}

}  // namespace curvd
