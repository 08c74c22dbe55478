#include "core/scale/judging/scale_judge.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <optional>

#include "core/scale/judging/position_noise.h"
#include "core/scale/pilot/sample_medians.h"

namespace curvd {
namespace {

// What differs from the reference is the candidate's bias if its square is so many times that of the reference's error.
constexpr double kLeastSquareOverReference = 2.0;
// The same of what differs from jets, which makes the normals doubtful: what jets are expected to err by must be far
// less.
constexpr double kLeastSquareOverJets = 9.0;
// A candidate whose noise and differences alone are so many times the least error has a weight of 1e-4.
constexpr double kHopeless = 10.0;
// What halves of few neighbors differ by is noise if it is so many times the squared bias: waves that they have lost
// make them differ as well.
constexpr double kLeastVarianceOverSquaredBias = 4.0;
// The rung that tells how the surface bends where no hexagrams can be compared.
constexpr size_t kRungIfUnknown = 2;

// The places of scores, the least error first.
std::vector<size_t> ByError(const std::vector<ScaleScore>& scores) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a].error < scores[b].error; });
  return order;
}

}  // namespace

ScaleJudge::ScaleJudge(PilotPoints table, const ScaleBounds& bounds, const LostDetail& lost_detail, Quantity quantity)
    : bounds_(bounds),
      differences_(table, quantity),
      lost_detail_(lost_detail),
      sigma_(PositionNoise(table).value_or(0.0)),
      noise_bias_(FindNoiseBias()) {
  // The Gaussian curvature takes its biases from the mean one.
  if (quantity == Quantity::kGaussian) return;
  for (size_t m = 0; m < kMethodCount; ++m) growing_bias_[m] = differences_.FindGrowingBias(m);
  noisy_ = FindNoisyMethods();
  reference_ = FindReference({kRegressionMethod});
  reference_of_positions_ = FindReferenceOfPositions();
}

std::vector<ScaleScore> ScaleJudge::Scores() const {
  std::vector<ScaleScore> scores;
  for (size_t m = 0; m < kMethodCount; ++m) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      if (differences_.OfCloud({m, rung}).has_value()) scores.push_back(ScoreWithoutBias({m, rung}, noisy_));
    }
  }
  // Biases only add to errors. They are looked for where they may matter, which is where most of the time goes.
  double least = std::numeric_limits<double>::infinity();
  for (const size_t i : ByError(scores)) {
    if (scores[i].error > kHopeless * least) break;
    scores[i] = ScoreOf(scores[i].candidate);
    least = std::min(least, scores[i].error);
  }
  for (size_t first = 0; first < scores.size(); ++first) {
    if (first == 0 || scores[first].candidate.method != scores[first - 1].candidate.method)
      MendFirstRung(first, scores);
  }
  std::erase_if(scores, [this](const ScaleScore& score) { return !IsAllowed(score.candidate); });
  return scores;
}

std::vector<ScaleScore> ScaleJudge::ScoresOf(const std::vector<ScaleScore>& of_mean,
                                             const ScaleJudge& judge_of_mean) const {
  std::optional<ScaleScore> reference = judge_of_mean.reference_, of_positions = judge_of_mean.reference_of_positions_;
  const MethodSet& noisy = judge_of_mean.noisy_;
  if (reference.has_value()) reference = ScoreAs(*reference, noisy);
  if (of_positions.has_value()) of_positions = ScoreAs(*of_positions, noisy);
  std::vector<ScaleScore> scores;
  scores.reserve(of_mean.size());
  for (const ScaleScore& mean : of_mean) scores.push_back(ScoreWithoutBias(mean.candidate, noisy));
  double least = std::numeric_limits<double>::infinity();
  for (const size_t i : ByError(scores)) {
    if (scores[i].error > kHopeless * least) break;
    const ScaleScore mean = of_mean[i].is_bias_known ? of_mean[i] : judge_of_mean.ScoreOf(of_mean[i].candidate);
    const double bias = ScoreAs(mean, noisy).bias;
    scores[i] = ScoreOf(mean.candidate,
                        std::max({bias * bias, SquaredBiasBeside(reference, mean.candidate),
                                  SquaredBiasOfNormals(of_positions, mean.candidate)}),
                        noisy);
    least = std::min(least, scores[i].error);
  }
  return scores;
}

ScaleScore ScaleJudge::ScoreAs(const ScaleScore& of_mean, const MethodSet& noisy) const {
  const double difference = *differences_.OfCloud(of_mean.candidate);
  const double bias = of_mean.difference > 0.0 ? of_mean.bias * difference / of_mean.difference : 0.0;
  return ScoreOf(of_mean.candidate, bias * bias, noisy);
}

bool ScaleJudge::IsAllowed(const ScaleCandidate& candidate) const {
  return bounds_.methods[candidate.method] && candidate.count() >= bounds_.least_count &&
         candidate.count() <= bounds_.most_count && differences_.MedianRadius(candidate.rung) <= bounds_.most_radius;
}

double ScaleJudge::FindNoiseBias() const {
  size_t best = kRungIfUnknown;
  double least = std::numeric_limits<double>::infinity();
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const std::optional<double> difference = differences_.OfCloud({kHexagramMethod, rung});
    if (difference.has_value() && *difference < least) {
      least = *difference;
      best = rung;
    }
  }
  // What changes curvatures by a part changes their product by twice that.
  const double factor = differences_.quantity() == Quantity::kGaussian ? 2.0 : 1.0;
  const PilotPoints table = differences_.table();
  const CandidateValues::Column values = differences_.values().Of({kHexagramMethod, best});
  const double bend = MedianOf(table, [&](const PilotPoint& point) {
    const auto place = static_cast<size_t>(&point - table.data());
    return factor * values.LengthAt(place) * point.steepest[best] * point.steepest[best];
  });
  return std::isfinite(bend) ? sigma_ * sigma_ * bend : 0.0;
}

std::optional<ScaleScore> ScaleJudge::FindReference(std::initializer_list<size_t> methods) const {
  std::vector<ScaleScore> without_bias;
  for (const size_t method : methods) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const ScaleCandidate candidate = {method, rung};
      if (differences_.OfCloud(candidate).has_value() && differences_.HasHalves(candidate)) {
        without_bias.push_back(ScoreWithoutBias(candidate, noisy_));
      }
    }
  }
  std::optional<ScaleScore> least;
  for (const size_t i : ByError(without_bias)) {
    if (least.has_value() && without_bias[i].error > least->error) break;
    const ScaleScore score = ScoreOf(without_bias[i].candidate);
    if (!least.has_value() || score.error < least->error) least = score;
  }
  return least;
}

std::optional<ScaleScore> ScaleJudge::FindReferenceOfPositions() const {
  if (!reference_.has_value() || !PositionsAreExact(differences_.table())) return std::nullopt;
  const std::optional<ScaleScore> jets = FindReference({kQuarticMethod, kSexticMethod});
  if (!jets.has_value() || SquaredBiasOfNormals(jets, reference_->candidate) == 0.0) return std::nullopt;
  return jets;
}

double ScaleJudge::SquaredBiasBeside(const std::optional<ScaleScore>& reference,
                                     const ScaleCandidate& candidate) const {
  if (!reference.has_value()) return 0.0;
  // Where a surface is flat at a large scale, all larger ones agree that its Gaussian curvature is 0, a product of two
  // small numbers: by any method.
  const bool looks_farther =
      differences_.quantity() == Quantity::kGaussian && candidate.rung > reference->candidate.rung;
  if (!kScaleMethods[candidate.method].is_second_order() && !looks_farther) return 0.0;
  const double found = differences_.CommonSquare(candidate, reference->candidate).value_or(0.0);
  // At the scale that is best for it, the reference has about as much bias as noise, which hides it.
  if (found < kLeastSquareOverReference * reference->error * reference->error) return 0.0;
  const double of_noise = NoiseBias(reference->candidate.method);
  return found - reference->bias * reference->bias - of_noise * of_noise;
}

double ScaleJudge::SquaredBiasOfNormals(const std::optional<ScaleScore>& jets, const ScaleCandidate& candidate) const {
  if (!jets.has_value() || kScaleMethods[candidate.method].is_jet()) return 0.0;
  double found = 0.0;
  // Neighborhoods too small for halves share no less of the normals' errors than the first that have them.
  for (size_t rung = candidate.rung; rung < kRungCount; ++rung) {
    const std::optional<double> common = differences_.CommonSquare({candidate.method, rung}, jets->candidate);
    if (!common.has_value()) continue;
    found = *common;
    break;
  }
  return found < kLeastSquareOverJets * jets->error * jets->error ? 0.0 : found - jets->bias * jets->bias;
}

double ScaleJudge::SquaredBiasOfChanges(const ScaleCandidate& candidate) const {
  const double growing = growing_bias_[candidate.method].At(candidate.rung);
  return std::max(growing * growing, lost_detail_.SquaredBias(candidate));
}

MethodSet ScaleJudge::FindNoisyMethods() const {
  MethodSet noisy{};
  for (size_t m = 0; m < kMethodCount; ++m) {
    const ScaleCandidate first = {m, differences_.FirstWithVariance(m)};
    noisy[m] = first.rung < kRungCount &&
               differences_.Variance(first) > kLeastVarianceOverSquaredBias * SquaredBiasOfChanges(first);
  }
  return noisy;
}

ScaleScore ScaleJudge::ScoreOf(const ScaleCandidate& candidate) const {
  const double squared_bias =
      std::max({differences_.CommonSquareBesideSmaller(candidate), SquaredBiasOfChanges(candidate),
                SquaredBiasBeside(reference_, candidate), SquaredBiasOfNormals(reference_of_positions_, candidate)});
  return ScoreOf(candidate, squared_bias, noisy_);
}

ScaleScore ScaleJudge::ScoreOf(const ScaleCandidate& candidate, double squared_bias, const MethodSet& noisy) const {
  const double difference = *differences_.OfCloud(candidate), of_halves = differences_.Variance(candidate);
  const bool is_before = of_halves == 0.0 && noisy[candidate.method];
  const double variance = is_before ? differences_.VarianceBeforeFirst(candidate) : of_halves;
  const double from_noise = NoiseBias(candidate.method);
  const double known = std::sqrt(std::max(difference * difference, variance + squared_bias) + from_noise * from_noise);
  const ScaleMethod& method = kScaleMethods[candidate.method];
  const double error = (differences_.quantity() == Quantity::kGaussian ? method.gaussian_doubt : method.doubt) * known;
  return {.candidate = candidate,
          .error = error,
          .difference = difference,
          .noise = std::sqrt(variance),
          .bias = std::sqrt(squared_bias),
          .bias_per_change = growing_bias_[candidate.method].PerChange(candidate.rung)};
}

ScaleScore ScaleJudge::ScoreWithoutBias(const ScaleCandidate& candidate, const MethodSet& noisy) const {
  ScaleScore score = ScoreOf(candidate, 0.0, noisy);
  score.is_bias_known = false;
  return score;
}

void ScaleJudge::MendFirstRung(size_t first, std::vector<ScaleScore>& scores) {
  if (scores.size() < first + 4) return;
  ScaleScore& score = scores[first];
  const ScaleScore &next = scores[first + 1], &later = scores[first + 3];
  if (later.candidate.rung != score.candidate.rung + 3) return;
  if (!(score.error < next.error && next.error < scores[first + 2].error && scores[first + 2].error < later.error))
    return;
  // Noise that no halves show may hide in the first difference: errors fall no faster than differences do there.
  const double least = score.error * (score.error / next.error);
  score.error = std::min(score.error, std::max(next.error * std::sqrt(next.error / later.error), least));
}

}  // namespace curvd
