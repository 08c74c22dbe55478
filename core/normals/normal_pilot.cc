#include "core/normals/normal_pilot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/edges/edge_parts.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/noisy_parts.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/sample_groups.h"
#include "core/normals/sample_view.h"
#include "core/normals/scale_judgement.h"

namespace curvd {
namespace {

// Two rungs double the count. Fewer neighbors than the first have no residual to tell noise by.
constexpr uint32_t kLadder[] = {12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384, 544, 768, NormalPilot::kMostNeighbors};
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

// Where the sample tells nothing.
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

// Adds those of a method, of at most so many neighbors.
void AddCandidates(NormalMethod method, size_t most, const SpatialIndex& index,
                   std::vector<SampleTable::Candidate>& candidates) {
  for (const uint32_t count : kLadder) {
    if (count > most) continue;
    const bool is_jet4 = method == NormalMethod::kJet4;
    if (is_jet4 && count < kLeastForJet4) continue;
    NormalFit fit;
    fit.method = method;
    fit.neighborhood = NeighborCount{count};
    if (count * index.point_count() > kMostOfAllPoints) {
      fit.shares = JetDegree(method) >= 2 && count >= NormalFit::kLeastShared;
      if (JetDegree(method) < 2 && count > kFewForPlanes) continue;
      if (is_jet4 && count > kFewForJet4) continue;
    }
    candidates.push_back({fit, NormalPlan(fit, index)});
  }
}

// REQUIRES: as NormalPilot has it.
std::vector<SampleTable::Candidate> CandidatesFor(const SpatialIndex& index, std::optional<NormalMethod> wanted,
                                                  uint32_t max_neighbor_count) {
  const size_t most = std::min<size_t>(index.point_count() / kLeastPointsPerNeighbor, max_neighbor_count);
  std::vector<SampleTable::Candidate> candidates;
  if (wanted.has_value()) {
    AddCandidates(*wanted, most, index, candidates);
  } else {
    for (const NormalMethod method : {NormalMethod::kJet2, NormalMethod::kJet4}) {
      AddCandidates(method, most, index, candidates);
    }
  }
  return candidates;
}

// `copies` is the mean number of points at the place of one, itself included.
SampleTable::Outcome OutcomeOf(const SampleTable::Candidate& candidate, double copies, const NormalScratch& fits,
                               const FittedPoint& fitted) {
  SampleTable::Outcome out{};
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

// Where parts are narrower than neighborhoods, the quiet one is left with so few neighbors that noise decides its
// normals. Those of many points of both parts then err less, and halves tell their noise.
bool KeepsNoise(const SampleView& quiet, const NormalFit& fit) {
  const uint32_t count = std::get<NeighborCount>(fit.neighborhood).count;
  return count < LeastNeighborCountOfHalves(fit.method) &&
         NoiseOfFit(quiet, fit.method, count).value_or(0.0) > kNegligibleError;
}

NoisyPart NoisyPartOf(const NormalFit& noisy, const SampleParts& parts) {
  return {.method = noisy.method,
          .neighborhood = std::get<NeighborCount>(noisy.neighborhood),
          .shares = noisy.shares,
          .crosses_lines = noisy.crosses_lines,
          .probe_count = parts.probe_count,
          .least_variance = parts.least_variance,
          .quiet_variance = parts.quiet_variance};
}

}  // namespace

NormalPilot::NormalPilot(const SpatialIndex& index, std::optional<NormalMethod> method, uint32_t max_neighbor_count,
                         int thread_count, NormalAim aim)
    : index_(index),
      aim_(aim),
      fallback_(FallbackFit(index.point_count(), method, max_neighbor_count)),
      table_(index, SampleGroups(index, kMostGroups), CandidatesFor(index, method, max_neighbor_count)),
      scratch_(thread_count) {}

absl::Status NormalPilot::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  const size_t c = block / table_.groups().size(), group = block % table_.groups().size();
  scratch.take = [this, c, group, &fits = scratch](const FittedPoint& fitted) {
    table_.outcome(c, group * SampleTable::kPointsPerGroup + fitted.point) =
        OutcomeOf(table_.candidates()[c], table_.copies(group), fits, fitted);
  };
  return FitGroup(index_, table_.candidates()[c].plan, table_.groups()[group], GroupSample::kOneOfEachLeaf, scratch);
}

ChosenFit NormalPilot::ChooseFrom(const SampleView& view) const { return ChooseOne(view, aim_, fallback_); }

ChosenFit NormalPilot::Choose() const {
  const std::optional<SampleParts> parts = FindParts(table_);
  if (!parts.has_value()) return MindEdges(table_, aim_, ChooseFrom(SampleView(table_)));
  const ChosenFit noisy = ChooseFrom(ViewOf(table_, *parts, true));
  const SampleView quiet = ViewOf(table_, *parts, false);
  ChosenFit chosen = ChooseFrom(quiet);
  if (KeepsNoise(quiet, chosen.fit)) {
    const SampleView both(table_, {}, 1.0, parts->noises);
    return MindEdges(table_, aim_, ChooseFrom(both));
  }
  chosen.noisy_sigma = noisy.sigma;
  chosen.noisy_share = parts->noisy_share;
  chosen.squared_error = (1.0 - parts->noisy_share) * chosen.squared_error + parts->noisy_share * noisy.squared_error;
  chosen.fit.noisy_part = NoisyPartOf(noisy.fit, *parts);
  return chosen;
}

std::optional<double> NormalPilot::NoiseOf(NormalMethod method, uint32_t neighbor_count) const {
  if (const std::optional<SampleParts> parts = FindParts(table_)) {
    const std::optional<double> noisy = NoiseOfFit(ViewOf(table_, *parts, true), method, neighbor_count);
    const std::optional<double> quiet = NoiseOfFit(ViewOf(table_, *parts, false), method, neighbor_count);
    if (quiet.has_value() && noisy.has_value()) {
      return (1.0 - parts->noisy_share) * *quiet + parts->noisy_share * *noisy;
    }
  }
  return NoiseOfFit(SampleView(table_), method, neighbor_count);
}

size_t NormalPilot::MostBlocks(size_t point_count, uint32_t max_neighbor_count) {
  if (std::min<size_t>(point_count / kLeastPointsPerNeighbor, max_neighbor_count) < kLadder[0]) return 0;
  const size_t groups = (point_count + SpatialIndex::kGroupPoints - 1) / SpatialIndex::kGroupPoints;
  return 2 * std::size(kLadder) * std::min(groups, kMostGroups);
}

size_t NormalPilot::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  NormalFit largest;
  largest.method = NormalMethod::kJet4;
  largest.neighborhood = NeighborCount{std::min(kMostNeighbors, max_neighbor_count)};
  return NormalScratch::MostBytes(largest, point_count);
}

}  // namespace curvd
