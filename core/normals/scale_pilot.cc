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
constexpr uint32_t kLadder[] = {12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384, 544};
constexpr uint32_t kLeastForJet4 = 24, kMostForJet4 = 384;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;
// Errors from bends count so much more than those from noise.
constexpr double kBendWeight = 3.0;
// Of fits whose squared error is at most this many times the least, the cheapest is taken.
constexpr double kGoodEnough = 1.5;
// Errors below this are all good enough: squared radians.
constexpr double kNegligible = 1e-10;
// Sampled differences above this quantile are cut down to it: edges of the surface are few.
constexpr double kClipQuantile = 0.95;
// Neighborhoods whose radius is less than this many standard deviations of the noise are balls of points more than
// pieces of a surface: nothing that is said of their fits holds.
constexpr double kLeastRadius = 5.0;

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

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Clipped {
  double mean;
  double standard_error;
};

// The mean of values that are cut down to their quantile kClipQuantile. REQUIRES: there are some.
Clipped ClippedMean(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(kClipQuantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  const double most = *at;
  double sum = 0.0, squares = 0.0;
  for (const double value : values) {
    const double clipped = std::min(value, most);
    sum += clipped;
    squares += clipped * clipped;
  }
  const double size = static_cast<double>(values.size()), mean = sum / size;
  return {mean, std::sqrt(std::max(squares / size - mean * mean, 0.0) / size)};
}

// Between two lines, small angles alone.
double SquaredAngle(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double minus = 0.0, plus = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double difference = static_cast<double>(a[axis]) - b[axis], sum = static_cast<double>(a[axis]) + b[axis];
    minus += difference * difference;
    plus += sum * sum;
  }
  return std::min(minus, plus);
}

// The power of rho with which the error of a jet's normal grows.
double BendOrder(NormalMethod method) {
  return method == NormalMethod::kJet4 ? 4.0 : method == NormalMethod::kJet2 ? 2.0 : 1.0;
}

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
                       int thread_count)
    : index_(index), scratch_(static_cast<size_t>(thread_count)) {
  const size_t points = index.point_count();
  fallback_.fit = FallbackFit(points, method, max_neighbor_count);
  const size_t groups = std::min(index.group_count(), kMostGroups);
  for (size_t i = 0; i < groups; ++i) groups_.push_back((2 * i + 1) * index.group_count() / (2 * groups));
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
    if (method == NormalMethod::kJet4 && (count < kLeastForJet4 || count > kMostForJet4)) continue;
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

std::optional<ScalePilot::Medians> ScalePilot::MediansOf(size_t candidate) const {
  const double count = candidates_[candidate].count();
  const double freedom = count - JetSize(std::max(candidates_[candidate].plan.degree, 1));
  std::vector<double> radii, variances;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    if (!point.ok) continue;
    radii.push_back(point.radius);
    variances.push_back(point.mean_square * count / freedom);
  }
  if (radii.empty()) return std::nullopt;
  return Medians{Median(radii), Median(variances)};
}

// Bends add to the residuals, and the more, the more neighbors there are: the smallest neighborhoods count that are
// large beside the noise. In smaller ones the residual is that of a ball of points.
std::optional<double> ScalePilot::Sigma() const {
  constexpr double kLeastFreedom = 8.0;  // of the fit, for a median that means something
  std::optional<double> sigma;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const double count = candidates_[c].count();
    if (candidates_[c].fit.method != candidates_.back().fit.method) continue;
    if (count < JetSize(std::max(candidates_[c].plan.degree, 1)) + kLeastFreedom) continue;
    const std::optional<Medians> medians = MediansOf(c);
    if (!medians.has_value()) continue;
    sigma = std::sqrt(medians->variance);
    if (medians->radius >= kLeastRadius * *sigma) break;
  }
  return sigma;
}

bool ScalePilot::IsLargeEnough(size_t candidate, double sigma) const {
  const std::optional<Medians> medians = MediansOf(candidate);
  return medians.has_value() && medians->radius >= kLeastRadius * sigma;
}

double ScalePilot::Noise(size_t candidate, double sigma) const {
  std::vector<double> noises;
  for (size_t i = 0; i < sample_count(); ++i) {
    if (outcome(candidate, i).ok) noises.push_back(outcome(candidate, i).noise);
  }
  return noises.empty() ? std::numeric_limits<double>::infinity() : sigma * sigma * ClippedMean(noises).mean;
}

double ScalePilot::Bends(size_t small, size_t large, double sigma) const {
  // Noise explains this much more than it should: coordinates within the plane are noisy too.
  constexpr double kSlack = 1.15;
  std::vector<double> changes, noises;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome &a = outcome(small, i), &b = outcome(large, i);
    if (!a.ok || !b.ok) continue;
    changes.push_back(SquaredAngle(a.normal, b.normal));
    // An estimate of least squares from more neighbors does not vary with its difference to one from some of them.
    noises.push_back(sigma * sigma * std::max(a.noise - b.noise, 0.0f));
  }
  if (changes.empty()) return 0.0;
  const Clipped change = ClippedMean(changes);
  // The error grows as a power of the radius, hence of the root of the count.
  const double shrink = static_cast<double>(candidates_[small].count()) / candidates_[large].count();
  const double seen = 1.0 - std::pow(shrink, 0.5 * BendOrder(candidates_[large].fit.method));
  const double beyond = change.mean - kSlack * ClippedMean(noises).mean - 2.0 * change.standard_error;
  return std::max(beyond, 0.0) / (seen * seen);
}

double ScalePilot::ErrorOf(size_t candidate, double sigma) const {
  const NormalMethod method = candidates_[candidate].fit.method;
  const double noise = Noise(candidate, sigma);
  const auto is_rung = [&](size_t c) {
    return c < candidates_.size() && candidates_[c].fit.method == method && IsLargeEnough(c, sigma);
  };
  double bends = 0.0;
  for (size_t large = candidate; is_rung(large); --large) {
    // What smaller neighborhoods show already is also in this one.
    for (const size_t step : {size_t{1}, size_t{2}, size_t{4}}) {
      if (large < step || !is_rung(large - step)) continue;
      bends = std::max(bends, Bends(large - step, large, sigma));
    }
    if (large == 0) break;
  }
  if (const bool is_first = candidate == 0 || !is_rung(candidate - 1); is_first && is_rung(candidate + 1)) {
    const double at_next = Bends(candidate, candidate + 1, sigma);
    const double shrink = static_cast<double>(candidates_[candidate].count()) / candidates_[candidate + 1].count();
    bends = at_next * std::pow(shrink, BendOrder(method));
  }
  return noise + kBendWeight * bends;
}

const ScalePilot::Candidate& ScalePilot::LargestOf(NormalMethod method) const {
  const auto is_it = [&](const Candidate& candidate) { return candidate.fit.method == method; };
  return *std::find_if(candidates_.rbegin(), candidates_.rend(), is_it);
}

ChosenScale ScalePilot::Choose() const {
  const std::optional<double> sigma = candidates_.empty() ? std::nullopt : Sigma();
  if (!sigma.has_value()) return fallback_;
  ChosenScale chosen = fallback_;
  std::vector<double> errors;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    errors.push_back(IsLargeEnough(c, *sigma) ? ErrorOf(c, *sigma) : std::numeric_limits<double>::infinity());
  }
  const double least = *std::min_element(errors.begin(), errors.end());
  const Candidate* cheapest = nullptr;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const bool is_good =
        errors[c] < std::numeric_limits<double>::infinity() && errors[c] <= std::max(kGoodEnough * least, kNegligible);
    if (is_good && (cheapest == nullptr || candidates_[c].cost() < cheapest->cost())) cheapest = &candidates_[c];
  }
  chosen.fit = cheapest != nullptr ? cheapest->fit : LargestOf(candidates_.front().fit.method).fit;
  chosen.fit.max_neighbor_count = fallback_.fit.max_neighbor_count;
  chosen.sigma = std::ldexp(*sigma, -index_.scale_exponent());
  return chosen;
}

size_t ScalePilot::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  NormalFit largest;
  largest.method = NormalMethod::kJet4;
  largest.neighborhood = NeighborCount{std::min<uint32_t>(kLadder[std::size(kLadder) - 1], max_neighbor_count)};
  return NormalScratch::MostBytes(largest, point_count);
}

std::unique_ptr<Phase> MakePilotPhase(ScalePilot& pilot) { return std::make_unique<PilotPhase>(pilot); }

}  // namespace curvd
