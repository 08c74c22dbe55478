#include "core/normals/trust/noise_probe.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <tuple>

#include "core/base/median.h"
#include "core/normals/normal_fit.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

constexpr size_t kMostNoiseGroups = 256;
// One group in so many is looked at first. The others are spared where means of these are so many times too small, or
// too large, for all rungs.
constexpr size_t kGroupsPerScout = 8;
constexpr double kBeyondDoubt = 4.0;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;
// Of the neighbors' normals, the length of the mean; beside edges and seams it is less. And the cosine between one of
// them and the mean: others have no slope.
constexpr double kLeastMeanNormal = 0.7, kLeastCosine = 0.3;
// Samples that differ from most do not count: those of planes that noise decides, and of normals that are outliers.
constexpr double kMostOfMedian = 10.0;
constexpr size_t kFewestToTell = 64;
constexpr double kLeastTold = 0.5;  // of the sample
// A mean is told from 0 by so many of its standard errors.
constexpr double kLeastDeviations = 4.5;
// Less noise of a plane's slope than that, squared, is none: a milliradian.
constexpr double kLeastNoise = 1e-6;
// Of what noise makes of a plane's slope, squared, what bends of the surface may make of it.
constexpr double kMostSurface = 0.3, kMostBends = 0.1;
// Of neighbors of a plane, the variance across over that along their longest axis. On a line they tell no slope across.
constexpr double kLeastHalfBreadth = 0.15;

constexpr int kWideSize = 9;  // of a polynomial of degree 3 that is 0 at the point
using WideRow = Eigen::Matrix<double, kWideSize, 1>;

// In the frame of the point and its neighbors' mean normal, in units of the farthest neighbor's distance.
struct Place {
  double x, y, height;
  double slope_x, slope_y;  // of the given normal; NaN: it has none
};

WideRow HeightRow(const Place& p) {
  WideRow row;
  row << p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y, p.x * p.x * p.x, p.x * p.x * p.y, p.x * p.y * p.y, p.y * p.y * p.y;
  return row;
}

WideRow SlopeRowX(const Place& p) {
  WideRow row;
  row << 1.0, 0.0, 2.0 * p.x, p.y, 0.0, 3.0 * p.x * p.x, 2.0 * p.x * p.y, p.y * p.y, 0.0;
  return row;
}

WideRow SlopeRowY(const Place& p) {
  WideRow row;
  row << 0.0, 1.0, 0.0, p.x, 2.0 * p.y, 0.0, p.x * p.x, 2.0 * p.x * p.y, 3.0 * p.y * p.y;
  return row;
}

// A neighbor of the scratch.
struct Ranked {
  float squared_distance;
  size_t j;
};

// The neighbors of the scratch by distance, copies of one place once; empty where their normals have no common side.
std::vector<Place> PlacesOf(const CollectScratch& s) {
  const NeighborArrays& n = s.neighbors;
  std::vector<Ranked> order;
  order.reserve(n.count);
  const auto offset = [&](size_t j) { return Eigen::Vector3d{n.dx[j], n.dy[j], n.dz[j]}; };
  const auto normal = [&](size_t j) { return Eigen::Vector3d{n.nx[j], n.ny[j], n.nz[j]}; };
  for (size_t j = 0; j < n.count; ++j) {
    if (normal(j).allFinite()) order.push_back({n.dx[j] * n.dx[j] + n.dy[j] * n.dy[j] + n.dz[j] * n.dz[j], j});
  }
  // In an order that does not depend on that of the neighbors, which differs between instruction sets.
  const auto rank = [&](size_t j) { return std::make_tuple(n.dx[j], n.dy[j], n.dz[j], s.ids[j]); };
  std::sort(order.begin(), order.end(), [&](const Ranked& a, const Ranked& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : rank(a.j) < rank(b.j);
  });
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Ranked& at : order) mean += normal(at.j);
  const double length = mean.norm();
  if (!(length > 0.0 && length >= kLeastMeanNormal * static_cast<double>(order.size()))) return {};
  mean /= length;
  const auto are_copies = [&](const Ranked& a, const Ranked& b) { return offset(a.j) == offset(b.j); };
  order.erase(std::unique(order.begin(), order.end(), are_copies), order.end());
  const Eigen::Vector3d u = mean.unitOrthogonal(), v = mean.cross(u);
  const double unit = 1.0 / offset(order.back().j).norm();
  std::vector<Place> places;
  places.reserve(order.size());
  for (const auto& [squared_distance, j] : order) {
    const Eigen::Vector3d at = unit * offset(j);
    const double cosine = normal(j).dot(mean), scale = cosine >= kLeastCosine ? -1.0 / cosine : std::nan("");
    places.push_back({at.dot(u), at.dot(v), at.dot(mean), scale * normal(j).dot(u), scale * normal(j).dot(v)});
  }
  return places;
}

// How the surface goes on around a point, by the normals of ever more places but the point's own.
class Surroundings {
 public:
  explicit Surroundings(const std::vector<Place>& places) : places_(places) {}

  // None where the first `count` places do not determine it. REQUIRES: `count` never falls.
  std::optional<WideRow> Fit(size_t count) {
    for (; taken_ < count; ++taken_) Add(places_[taken_]);
    const auto [moments, products] = Equations();
    const Eigen::LDLT<Moments> solver(moments);
    constexpr double kLeastPivot = 1e-9;
    const auto pivots = solver.vectorD();
    if (solver.info() != Eigen::Success || !(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return std::nullopt;
    return solver.solve(products);
  }

 private:
  using Moments = Eigen::Matrix<double, kWideSize, kWideSize>;
  // Of the terms of a row, exponents of x and y.
  static constexpr int kExponents[kWideSize][2] = {{1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2},
                                                   {3, 0}, {2, 1}, {1, 2}, {0, 3}};
  static constexpr int kMostOfSlope = 2, kMostOfSquare = 2 * kMostOfSlope;  // degrees

  void Add(const Place& p) {
    if (std::isnan(p.slope_x)) return;
    double of_x[kMostOfSquare + 1] = {1.0}, of_y[kMostOfSquare + 1] = {1.0};
    for (int k = 1; k <= kMostOfSquare; ++k) {
      of_x[k] = of_x[k - 1] * p.x;
      of_y[k] = of_y[k - 1] * p.y;
    }
    for (int a = 0; a <= kMostOfSquare; ++a) {
      for (int b = 0; a + b <= kMostOfSquare; ++b) powers_[a][b] += of_x[a] * of_y[b];
    }
    for (int a = 0; a <= kMostOfSlope; ++a) {
      for (int b = 0; a + b <= kMostOfSlope; ++b) {
        along_x_[a][b] += p.slope_x * of_x[a] * of_y[b];
        along_y_[a][b] += p.slope_y * of_x[a] * of_y[b];
      }
    }
  }

  struct NormalEquations {
    Moments moments;
    WideRow products;
  };
  // The sums of products of SlopeRowX, and of SlopeRowY, which are powers of x and y with factors.
  NormalEquations Equations() const {
    NormalEquations sums{Moments::Zero(), WideRow::Zero()};
    for (int k = 0; k < kWideSize; ++k) {
      const auto [a, b] = kExponents[k];
      if (a > 0) sums.products[k] += a * along_x_[a - 1][b];
      if (b > 0) sums.products[k] += b * along_y_[a][b - 1];
      for (int l = 0; l <= k; ++l) {
        const auto [c, d] = kExponents[l];
        double sum = 0.0;
        if (a > 0 && c > 0) sum += a * c * powers_[a + c - 2][b + d];
        if (b > 0 && d > 0) sum += b * d * powers_[a + c][b + d - 2];
        sums.moments(k, l) = sums.moments(l, k) = sum;
      }
    }
    return sums;
  }

  const std::vector<Place>& places_;
  size_t taken_ = 1;
  // Sums of x^a y^b, and of these times a slope.
  double powers_[kMostOfSquare + 1][kMostOfSquare + 1] = {};
  double along_x_[kMostOfSlope + 1][kMostOfSlope + 1] = {}, along_y_[kMostOfSlope + 1][kMostOfSlope + 1] = {};
};

// The variance of places across their longest axis over that along it, by the sums of products of 1, x and y.
double Breadth(const Eigen::Matrix3d& moments) {
  const Eigen::Vector2d mean = moments.block<2, 1>(1, 0) / moments(0, 0);
  const Eigen::Matrix2d covariance = moments.block<2, 2>(1, 1) / moments(0, 0) - mean * mean.transpose();
  const double middle = 0.5 * covariance.trace();
  const double deviation = std::sqrt(std::max(middle * middle - covariance.determinant(), 0.0));
  return (middle - deviation) / (middle + deviation);
}

// The slopes at the point of two planes, through every other one of the first `count` places each.
struct HalfPlanes {
  Eigen::Vector2d of_heights[2];
  Eigen::Vector2d of_bends[2];  // through the heights that the normals' slopes make beyond the fit
};

// None where a half lies on a line.
std::optional<HalfPlanes> FitHalves(const std::vector<Place>& places, size_t count, const WideRow& others) {
  Eigen::Matrix3d moments[2] = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  Eigen::Matrix<double, 3, 2> products[2] = {Eigen::Matrix<double, 3, 2>::Zero(), Eigen::Matrix<double, 3, 2>::Zero()};
  for (size_t j = 0; j < count; ++j) {
    const Place& p = places[j];
    const Eigen::Vector3d row{1.0, p.x, p.y};
    const double height = p.height - others.dot(HeightRow(p));
    // Along the way from the point, the slope grows to this.
    const double slope = (p.slope_x - others.dot(SlopeRowX(p))) * p.x + (p.slope_y - others.dot(SlopeRowY(p))) * p.y;
    moments[j % 2].noalias() += row * row.transpose();
    products[j % 2].noalias() += row * Eigen::RowVector2d{height, std::isnan(slope) ? 0.0 : 0.5 * slope};
  }
  HalfPlanes planes;
  for (size_t half = 0; half < 2; ++half) {
    if (!(Breadth(moments[half]) >= kLeastHalfBreadth)) return std::nullopt;
    const Eigen::Matrix<double, 3, 2> solution = moments[half].ldlt().solve(products[half]);
    planes.of_heights[half] = solution.col(0).tail<2>();
    planes.of_bends[half] = solution.col(1).tail<2>();
  }
  return planes;
}

}  // namespace

NoiseProbe::NoiseProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index), scratch_(thread_count) {
  if (ScratchBytes(index.point_count(), max_neighbor_count) == 0) return;
  const std::vector<size_t> groups = SampleGroups(index, kMostNoiseGroups);
  const auto take = [&](bool scouts) {
    for (size_t i = 0; i < groups.size(); ++i) {
      if ((i % kGroupsPerScout == 0) == scouts) groups_.push_back(groups[i]);
    }
  };
  groups_.reserve(groups.size());
  take(true);
  scout_count_ = groups_.size();
  take(false);
  plan_ = NeighborhoodPlan::Make(PlaneFit(kNeighbors).ToEstimatorOptions(), index);
  samples_.resize(kRungs.size() * sample_count(), Sample{.noise = std::numeric_limits<double>::quiet_NaN()});
}

bool NoiseProbe::AddBlocks() {
  first_block_ += block_count_;
  if (first_block_ == 0) {
    block_count_ = scout_count_;
  } else {
    block_count_ =
        first_block_ == scout_count_ && MayTell() && HasFewCopies(index_) ? groups_.size() - scout_count_ : 0;
  }
  return block_count_ > 0;
}

absl::Status NoiseProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  CollectScratch& s = scratch_.Of(worker, stopped);
  const auto leaf_of = [&s](size_t i) { return static_cast<size_t>(s.points.place[i]) / SpatialIndex::kLeafSize; };
  const size_t place = first_block_ + block, first_sample = place * SpatialIndex::kGroupLeaves;
  return CollectNeighbors(
      index_, *plan_, groups_[place], CollectedPoints::kAll, CollectedNormals::kInUse, s,
      [&s](size_t i) { return s.points.place[i] % SpatialIndex::kLeafSize == 0; },
      [&](size_t i) { Take(s, first_sample + leaf_of(i) % SpatialIndex::kGroupLeaves); });
}

void NoiseProbe::Take(const CollectScratch& scratch, size_t i) {
  const std::vector<Place> places = PlacesOf(scratch);
  if (places.empty() || std::isnan(places.front().slope_x)) return;
  Surroundings surroundings(places);
  for (size_t rung = 0; rung < kRungs.size(); ++rung) {
    if (kRungs[rung].around >= places.size()) return;
    const std::optional<WideRow> others = surroundings.Fit(kRungs[rung].around + 1);
    if (!others.has_value()) continue;
    const std::optional<HalfPlanes> planes = FitHalves(places, kRungs[rung].planes, *others);
    if (!planes.has_value()) continue;
    const Eigen::Vector2d &one = planes->of_heights[0], &other = planes->of_heights[1];
    const Eigen::Vector2d normal{places.front().slope_x - (*others)[0], places.front().slope_y - (*others)[1]};
    const double surface = one.dot(other);
    sample(rung, i) = {.noise = 0.25 * (one - other).squaredNorm(),
                       .bends = 0.25 * (planes->of_bends[0] - planes->of_bends[1]).squaredNorm(),
                       .surface = surface,
                       .shared = 0.5 * normal.dot(one + other) - surface,
                       .normal = normal.squaredNorm()};
  }
}

NoiseProbe::Means NoiseProbe::MeansOf(std::span<const Sample> samples) {
  const auto most = [&](double Sample::*member) {
    std::vector<double> known;
    for (const Sample& s : samples) {
      if (std::isfinite(s.noise)) known.push_back(s.*member);
    }
    return known.empty() ? 0.0 : kMostOfMedian * Median(known);
  };
  Means means{.most_noise = most(&Sample::noise), .most_normal = most(&Sample::normal), .count = 0.0, .of = {}};
  for (const Sample& s : samples) {
    if (!means.Counts(s)) continue;
    means.count += 1.0;
    for (double Sample::*member : kMembers) means.of.*member += s.*member;
  }
  for (double Sample::*member : kMembers) means.of.*member /= means.count;
  return means;
}

bool NoiseProbe::MayTell() const {
  for (size_t rung = 0; rung < kRungs.size(); ++rung) {
    const Means means = MeansOf(SamplesOf(rung).first(scout_count_ * SpatialIndex::kGroupLeaves));
    const Sample& of = means.of;
    if (!(means.count > 0.0)) return true;
    const double noise = kBeyondDoubt * of.noise;
    if (noise >= kLeastNoise && of.surface <= kMostSurface * noise && of.bends <= kMostBends * noise) return true;
  }
  return false;
}

std::optional<NoiseProbe::Finding> NoiseProbe::FindingAt(size_t rung) const {
  const std::span<const Sample> samples = SamplesOf(rung);
  const Means means = MeansOf(samples);
  const auto& [noise, bends, surface, shared, normal] = means.of;
  if (means.count < kFewestToTell || means.count < kLeastTold * static_cast<double>(samples.size())) {
    return std::nullopt;
  }
  if (noise < kLeastNoise) return std::nullopt;
  // The points of a group have neighbors in common.
  double squares = 0.0;
  for (size_t first = 0; first < samples.size(); first += SpatialIndex::kGroupLeaves) {
    double of_group = 0.0;
    for (const Sample& s : samples.subspan(first, SpatialIndex::kGroupLeaves)) {
      of_group += means.Counts(s) ? s.shared - shared : 0.0;
    }
    squares += of_group * of_group;
  }
  const double deviation = std::sqrt(squares) / means.count;
  // Of bends that are left, a plane shows a part a, the normal all. Of their square they share a, and halves of the
  // plane a^2, which is at least half of that as long as bends are small. And what bends make of uneven neighbors
  // differs between halves: on grids it makes their product negative.
  const bool shows_noise = surface <= kMostSurface * noise && bends <= kMostBends * noise;
  const double follows = shows_noise ? shared - std::abs(surface) - bends : 0.0;
  return Finding{follows / deviation, std::max(normal - surface, 0.0)};
}

std::optional<double> NoiseProbe::SquaredError() const {
  std::optional<double> error;
  double most = kLeastDeviations;
  for (size_t rung = 0; rung < kRungs.size(); ++rung) {
    const std::optional<Finding> finding = FindingAt(rung);
    if (!finding.has_value() || !(finding->deviations > most)) continue;
    most = finding->deviations;
    error = finding->squared_error;
  }
  return error;
}

size_t NoiseProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  if (std::min<size_t>(point_count / kLargestShare, max_neighbor_count) < kNeighbors) return 0;
  return CollectScratch::MostBytes(PlaneFit(kNeighbors).ToEstimatorOptions(), point_count) +
         kNeighbors * (sizeof(Ranked) + sizeof(Place));
}

}  // namespace curvd
