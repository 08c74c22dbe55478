#include "core/normals/scale_pilot.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "Eigen/Cholesky"
#include "core/base/copies.h"
#include "core/base/median.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

// Two rungs double the count. Fewer neighbors than the first have no residual to tell noise by.
constexpr uint32_t kLadder[] = {12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384, 544, 768, ScalePilot::kMostNeighbors};
constexpr uint32_t kLeastForJet4 = 24;
// All points together take this many neighbors at most, so that large clouds are not kept waiting: beyond, the points
// of a leaf share a fit. Planes cannot be shared; they take more neighbors as long as those are few for each point. Nor
// do jets of degree 4 take more than a few: what chance shows of bends in jets of degree 2 of few neighbors would speak
// for them, though noise moves those of degree 4 twice as far at the same count.
constexpr size_t kMostOfAllPoints = 400'000'000;
constexpr uint32_t kFewForPlanes = 544, kFewForJet4 = 384;

// Returns the trace of the covariance of the two slopes of a fit where the point reads it, for noise of unit variance
// and lengths in units of rho.
double SlopeVariance(const JetSystems& jets, int degree, const FittedPoint& fitted) {
  const int size = JetSize(degree);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJetSize, kMaxJetSize> moments(size, size);
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxJetSize, 2> slopes(size, 2);
  const auto power = [](double x, int p) { return p < 0 ? 0.0 : std::pow(x, p); };
  for (int p = 0, row = 0; p <= degree; ++p) {
    for (int b = 0; b <= p; ++b, ++row) {
      const int a = p - b;
      slopes(row, 0) = a * power(fitted.u, a - 1) * power(fitted.v, b);
      slopes(row, 1) = b * power(fitted.u, a) * power(fitted.v, b - 1);
      for (int q = 0, column = 0; q <= degree; ++q) {
        for (int d = 0; d <= q; ++d, ++column) {
          moments(row, column) = jets.moments[JetIndex(a + q - d, b + d)][fitted.system];
        }
      }
    }
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxJetSize, 2> solution = moments.ldlt().solve(slopes);
  return solution.cwiseProduct(slopes).sum();
}

// The same for neighbors that fill a disc evenly.
double DiscVariance(int degree, size_t count) { return (degree == 4 ? 72.0 : 8.0) / static_cast<double>(count); }

NormalFit FallbackFit(size_t points, std::optional<NormalMethod> wanted, uint32_t max_neighbor_count) {
  constexpr size_t kEnough = 24;
  NormalFit fit;
  const size_t count = std::min<size_t>({points, max_neighbor_count, kEnough});
  fit.neighborhood = NeighborCount{static_cast<uint32_t>(count)};
  fit.max_neighbor_count = max_neighbor_count;
  fit.method = wanted.value_or(count >= size_t{2} * LeastNeighborCount(NormalMethod::kJet2) ? NormalMethod::kJet2
                                                                                            : NormalMethod::kPca);
  return fit;
}

}  // namespace

double MeanCopies(const SpatialIndex& index, size_t group) {
  using Position = std::array<float, 3>;
  std::array<Position, SpatialIndex::kGroupPoints> positions;
  size_t count = 0;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) positions[count++] = {points.x[i], points.y[i], points.z[i]};
  }
  constexpr size_t kTellDistance = 16;
  if (count <= kTellDistance) return 1.0;
  const auto squared = [&](size_t i, size_t j) {
    const float x = positions[i][0] - positions[j][0], y = positions[i][1] - positions[j][1],
                z = positions[i][2] - positions[j][2];
    return x * x + y * y + z * z;
  };
  // Of neighborhoods of so many points, itself included.
  std::vector<double> radii;
  std::array<float, SpatialIndex::kGroupPoints> distances;
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) distances[j] = squared(i, j);
    std::nth_element(distances.begin(), distances.begin() + (kTellDistance - 1), distances.begin() + count);
    radii.push_back(std::sqrt(distances[kTellDistance - 1]));
  }
  NearCopies copies(static_cast<float>(Median(radii)), kTellDistance);
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < i; ++j) copies.AddPair(squared(i, j));
  }
  const float most = copies.Exist() ? copies.distance() * copies.distance() : 0.0f;
  size_t pairs = 0;  // each point's with itself included
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) pairs += squared(i, j) <= most ? 1 : 0;
  }
  return static_cast<double>(pairs) / static_cast<double>(count);
}

ScalePilot::ScalePilot(const SpatialIndex& index, std::optional<NormalMethod> method, uint32_t max_neighbor_count,
                       int thread_count, NormalAim aim)
    : index_(index),
      aim_(aim),
      lattice_step_(LatticeStep(index)),
      groups_(SampleGroups(index, kMostGroups)),
      scratch_(thread_count) {
  for (const size_t group : groups_) copies_.push_back(MeanCopies(index, group));
  const size_t points = index.point_count();
  fallback_.fit = FallbackFit(points, method, max_neighbor_count);
  const size_t most = std::min<size_t>(points / kLeastTimes, max_neighbor_count);
  for (const NormalMethod candidate : {NormalMethod::kJet2, NormalMethod::kJet4}) {
    if (!method.has_value()) AddCandidates(candidate, most);
  }
  if (method.has_value()) AddCandidates(*method, most);
  outcomes_.resize(candidates_.size() * sample_count());
}

void ScalePilot::AddCandidates(NormalMethod method, size_t most) {
  for (const uint32_t count : kLadder) {
    if (count > most) continue;
    const bool is_jet4 = method == NormalMethod::kJet4;
    if (is_jet4 && count < kLeastForJet4) continue;
    NormalFit fit;
    fit.method = method;
    fit.neighborhood = NeighborCount{count};
    if (count * index_.point_count() > kMostOfAllPoints) {
      fit.shares = JetDegree(method) >= 2 && count >= NormalFit::kLeastShared;
      if (JetDegree(method) < 2 && count > kFewForPlanes) continue;
      if (is_jet4 && count > kFewForJet4) continue;
    }
    candidates_.push_back({fit, NormalPlan(fit, index_)});
  }
}

absl::Status ScalePilot::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  const size_t c = block / groups_.size(), group = block % groups_.size();
  scratch.take = [this, c, group, &fits = scratch](const FittedPoint& fitted) {
    outcome(c, group * kPointsPerGroup + fitted.point) = OutcomeOf(candidates_[c], copies_[group], fits, fitted);
  };
  return FitGroup(index_, candidates_[c].plan, groups_[group], GroupSample::kOneOfEachLeaf, scratch);
}

ScalePilot::Outcome ScalePilot::OutcomeOf(const Candidate& candidate, double copies, const NormalScratch& fits,
                                          const FittedPoint& fitted) {
  Outcome out{};
  out.is_fitted = true;
  for (size_t axis = 0; axis < 3; ++axis) out.normal[axis] = static_cast<float>(fitted.normal[axis]);
  out.radius = fits.frames.rho[fitted.system];
  const int degree = candidate.plan.degree;
  const double variance =
      degree == 0 ? DiscVariance(degree, candidate.count()) : SlopeVariance(fits.system, degree, fitted);
  out.mean_square = static_cast<float>(fitted.mean_square) * out.radius * out.radius;
  out.noise = static_cast<float>(copies * variance) / (out.radius * out.radius);
  // A plane errs as much along the width of its neighbors as they are narrow.
  const double even = DiscVariance(degree, candidate.count());
  out.excess =
      static_cast<float>(degree == 0 ? 0.5 + 0.5 / std::max(fits.breadth[fitted.system], 1e-6) : variance / even);
  return out;
}

size_t ScalePilot::MostBlocks(size_t point_count, uint32_t max_neighbor_count) {
  if (std::min<size_t>(point_count / kLeastTimes, max_neighbor_count) < kLadder[0]) return 0;
  const size_t groups = (point_count + SpatialIndex::kGroupPoints - 1) / SpatialIndex::kGroupPoints;
  return 2 * std::size(kLadder) * std::min(groups, kMostGroups);
}

size_t ScalePilot::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  NormalFit largest;
  largest.method = NormalMethod::kJet4;
  largest.neighborhood = NeighborCount{std::min(kMostNeighbors, max_neighbor_count)};
  return NormalScratch::MostBytes(largest, point_count);
}

}  // namespace curvd
