#include "core/normals/scale_pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "Eigen/Cholesky"
#include "core/estimators/fits/jet_systems.h"

namespace curvd {
namespace {

// Two rungs double the count. Fewer neighbors than the first have no residual to tell noise by; what more neighbors
// than the last could still smooth, whoever uses the normals can, at less cost.
constexpr uint32_t kLadder[] = {12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384, 544, 768, 1086};
constexpr uint32_t kLeastForJet4 = 24;
// All points together take this many neighbors at most, so that large clouds are not kept waiting, unless they are
// fewer than kFewForJet2 or kFewForJet4 for each.
constexpr size_t kMostOfAllPoints = 400'000'000;
constexpr uint32_t kFewForJet2 = 544, kFewForJet4 = 384;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;

// Returns the trace of the covariance of the two slopes of the fit of point i, for noise of unit variance and lengths
// in units of rho.
double SlopeVariance(const JetSystems& jets, int degree, size_t i) {
  const int size = JetSize(degree);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJetSize, kMaxJetSize> moments(size, size);
  for (int p = 0, row = 0; p <= degree; ++p) {
    for (int b = 0; b <= p; ++b, ++row) {
      for (int q = 0, column = 0; q <= degree; ++q) {
        for (int d = 0; d <= q; ++d, ++column) {
          moments(row, column) = jets.moments[JetIndex(p - b + q - d, b + d)][i];
        }
      }
    }
  }
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxJetSize, 2> slopes(size, 2);
  slopes.setZero();
  slopes(JetIndex(1, 0), 0) = slopes(JetIndex(0, 1), 1) = 1.0;
  const Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxJetSize, 2> solution = moments.ldlt().solve(slopes);
  return solution(JetIndex(1, 0), 0) + solution(JetIndex(0, 1), 1);
}

// The same for a plane, over an even disc.
double PlaneVariance(size_t count) { return 8.0 / static_cast<double>(count); }

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

class PilotPhase final : public Phase {
 public:
  explicit PilotPhase(ScalePilot& pilot) : pilot_(pilot) {}
  std::string_view name() const override { return "normals"; }
  absl::StatusOr<size_t> Begin() override { return pilot_.block_count(); }
  absl::Status RunBlock(const BlockContext& context) override {
    return pilot_.RunBlock(context.block, context.worker, context.stopped);
  }

 private:
  ScalePilot& pilot_;
};

}  // namespace

ScalePilot::ScalePilot(const SpatialIndex& index, std::optional<NormalMethod> method, uint32_t max_neighbor_count,
                       int thread_count, NormalAim aim)
    : index_(index),
      aim_(aim),
      lattice_step_(LatticeStep(index)),
      groups_(SampleGroups(index, kMostGroups)),
      scratch_(static_cast<size_t>(thread_count)) {
  const size_t points = index.point_count();
  fallback_.fit = FallbackFit(points, method, max_neighbor_count);
  const size_t most = std::min<size_t>(points / kLargestShare, max_neighbor_count);
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
    if (count > (is_jet4 ? kFewForJet4 : kFewForJet2) && count * index_.point_count() > kMostOfAllPoints) continue;
    NormalFit fit;
    fit.method = method;
    fit.neighborhood = NeighborCount{count};
    candidates_.push_back({fit, NormalPlan(fit, index_)});
  }
}

absl::Status ScalePilot::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  std::unique_ptr<NormalScratch>& scratch = scratch_[static_cast<size_t>(worker)];
  if (scratch == nullptr) {
    scratch = std::make_unique<NormalScratch>();
    scratch->most_work = std::numeric_limits<uint64_t>::max();  // four points are few
  }
  scratch->stopped = &stopped;
  const size_t c = block / groups_.size(), group = block % groups_.size();
  const absl::Status status =
      FitGroup(index_, candidates_[c].plan, groups_[group], GroupSample::kOneOfEachLeaf, *scratch);
  for (size_t i = 0; status.ok() && i < kPointsPerGroup; ++i) {
    outcome(c, group * kPointsPerGroup + i) = OutcomeOf(candidates_[c], *scratch, i);
  }
  return status;
}

ScalePilot::Outcome ScalePilot::OutcomeOf(const Candidate& candidate, const NormalScratch& fits, size_t i) {
  Outcome out{};
  out.ok = i < fits.points.size && fits.points.status[i] == PointStatus::kOk;
  if (!out.ok) return out;
  out.normal = {static_cast<float>(fits.normal.x[i]), static_cast<float>(fits.normal.y[i]),
                static_cast<float>(fits.normal.z[i])};
  out.radius = fits.frames.rho[i];
  const int degree = candidate.plan.degree;
  const double variance = degree == 0 ? PlaneVariance(candidate.count()) : SlopeVariance(fits.system, degree, i);
  out.mean_square = static_cast<float>(fits.mean_square[i]) * out.radius * out.radius;
  out.noise = static_cast<float>(variance) / (out.radius * out.radius);
  return out;
}

size_t ScalePilot::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  NormalFit largest;
  largest.method = NormalMethod::kJet4;
  largest.neighborhood = NeighborCount{std::min<uint32_t>(kLadder[std::size(kLadder) - 1], max_neighbor_count)};
  return NormalScratch::MostBytes(largest, point_count);
}

std::unique_ptr<Phase> MakePilotPhase(ScalePilot& pilot) { return std::make_unique<PilotPhase>(pilot); }

}  // namespace curvd
