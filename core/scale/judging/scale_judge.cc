#include "core/scale/judging/scale_judge.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/order_statistic.h"

namespace curvd {
namespace {

// Of the sampled points, so many must have an estimate, or a difference of halves, for a candidate to be judged.
constexpr double kLeastShare = 0.97, kLeastShareOfHalves = 0.95;
// At the least, unless the table has fewer.
constexpr size_t kLeastPoints = 16;
// The difference from the next larger scale is so much smaller than the error.
constexpr double kErrorPerDifference = 1.2;
// Products of differences beyond these quantiles are cut down to them: edges of the surface are few.
constexpr double kProductQuantile = 0.95;
// A quarter of the squared median difference of halves, times this, is the variance of their mean, if it is Gaussian.
constexpr double kVariancePerSquaredMedian = 2.2;
// The same of vectors of two components: the squared median length of them is 2 ln 2 times the variance of one.
constexpr double kVariancePerSquaredMedianOfVectors = 1.44;
// The mean of those products tells a bias if it is at least this share of their root mean square. It is looked for at a
// dozen smaller rungs, and noise of the smallest, which is thousands of times the bias of larger ones, comes to twice
// its standard error by chance.
constexpr double kLeastCommon = 0.25;
// Differences at single points beyond this quantile are cut down to it.
constexpr double kDifferenceQuantile = 0.99;
// Rounding of normals to float32 moves the curvature of the first rung by up to this many times 1 / radius: no
// difference says less. That of more normals averages out, as noise does.
constexpr double kRounding = 1e-6;
// The rung from which the residual of a jet of degree 4 tells the noise.
constexpr size_t kResidualRung = 2;
// What differs from the reference is the candidate's bias if its square is so many times that of the reference's error.
constexpr double kLeastSquareOverReference = 2.0;
// The same of what differs from jets, which makes the normals doubtful: what jets are expected to err by must be far
// less.
constexpr double kLeastSquareOverJets = 9.0;
// Noise of the positions that is at most this share of the radius of the first rung leaves them exact.
constexpr double kMostNoiseOfExactPositions = 1e-3;
// Noise is told from the surface in neighborhoods that are so many times larger.
constexpr double kLeastRadiusOverNoise = 4.0;
// A candidate whose noise and differences alone are so many times the least error has a weight of 1e-4.
constexpr double kHopeless = 10.0;

double Quantile(std::vector<double> values, double share) {
  return OrderStatistic(values, static_cast<size_t>(share * static_cast<double>(values.size() - 1)));
}

double Median(std::vector<double> values) { return OrderStatistic(values, values.size() / 2); }

// The mean of values of which those beyond the quantile are cut down to it.
double CutMean(const std::vector<double>& values) {
  const double most = Quantile(values, kDifferenceQuantile);
  double sum = 0.0;
  for (const double value : values) sum += std::min(value, most);
  return sum / static_cast<double>(values.size());
}

// Of the values that are finite; infinity if there are none.
template <typename Value>
double MedianOf(PilotPoints table, const Value& value) {
  std::vector<double> values;
  values.reserve(table.size());
  for (const PilotPoint& point : table) {
    if (const double v = value(point); std::isfinite(v)) values.push_back(v);
  }
  return values.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(values));
}

// The places of scores, the least error first.
std::vector<size_t> ByError(const std::vector<ScaleScore>& scores) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a].error < scores[b].error; });
  return order;
}

double MedianRadius(PilotPoints table, size_t rung) {
  return MedianOf(table, [rung](const auto& p) { return p.radius[rung]; });
}

}  // namespace

ScaleJudge::ScaleJudge(PilotPoints table, const ScaleBounds& bounds, Quantity quantity)
    : table_(table), bounds_(bounds), quantity_(quantity), values_(table, quantity) {
  for (const PilotPoint& point : table_) {
    for (size_t rung = 0; rung < point.clear_rungs; ++rung) ++clear_counts_[rung];
  }
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    median_radii_[rung] = MedianRadius(table_, rung);
    floors_[rung] = FloorAt(rung);
  }
  for (size_t m = 0; m < kMethodCount; ++m) {
    const size_t step = kScaleMethods[m].compared_rungs;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      differences_[m][rung] = MedianDifference({m, rung}, step);
      variances_[m][rung] = Variance({m, rung});
    }
    AddLastDifferences(m);
  }
  FindNoise();
  if (quantity == Quantity::kGaussian) return;
  lost_detail_ = LostDetail(table_, median_radii_);
  reference_ = FindReference({kRegressionMethod});
  reference_of_positions_ = FindReferenceOfPositions();
}

std::vector<ScaleScore> ScaleJudge::Scores() const {
  std::vector<ScaleScore> scores;
  for (size_t m = 0; m < kMethodCount; ++m) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      if (differences_[m][rung].has_value()) scores.push_back(ScoreWithoutBias({m, rung}));
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
  if (reference.has_value()) reference = ScoreAs(*reference);
  if (of_positions.has_value()) of_positions = ScoreAs(*of_positions);
  std::vector<ScaleScore> scores;
  scores.reserve(of_mean.size());
  for (const ScaleScore& mean : of_mean) scores.push_back(ScoreWithoutBias(mean.candidate));
  double least = std::numeric_limits<double>::infinity();
  for (const size_t i : ByError(scores)) {
    if (scores[i].error > kHopeless * least) break;
    const ScaleScore mean = of_mean[i].is_bias_known ? of_mean[i] : judge_of_mean.ScoreOf(of_mean[i].candidate);
    const double bias = ScoreAs(mean).bias;
    scores[i] = ScoreOf(mean.candidate, std::max({bias * bias, SquaredBiasBeside(reference, mean.candidate),
                                                  SquaredBiasOfNormals(of_positions, mean.candidate)}));
    least = std::min(least, scores[i].error);
  }
  return scores;
}

ScaleScore ScaleJudge::ScoreAs(const ScaleScore& of_mean) const {
  const double difference = *differences_[of_mean.candidate.method][of_mean.candidate.rung];
  const double bias = of_mean.difference > 0.0 ? of_mean.bias * difference / of_mean.difference : 0.0;
  return ScoreOf(of_mean.candidate, bias * bias);
}

std::vector<double> ScaleJudge::DifferencesAtPoints(const ScaleScore& score, PilotPoint::Part part) const {
  const size_t step = kScaleMethods[score.candidate.method].compared_rungs;
  const size_t rung = ComparedRung(score.candidate);
  std::vector<double> errors(table_.size(), std::numeric_limits<double>::quiet_NaN()), known;
  if (rung + step < kRungCount) {
    const CandidateValues::Column one = values_.Of({score.candidate.method, rung}, part);
    const CandidateValues::Column next = values_.Of({score.candidate.method, rung + step}, part);
    for (size_t i = 0; i < table_.size(); ++i) {
      errors[i] = one.DistanceAt(i, next);
      if (std::isfinite(errors[i])) known.push_back(errors[i]);
    }
  }
  if (known.empty()) return std::vector<double>(table_.size(), 1.0);
  const double most = Quantile(known, kDifferenceQuantile);
  const double usual = std::min(kErrorPerDifference * Median(std::move(known)), most);
  for (size_t i = 0; i < table_.size(); ++i) {
    const bool is_clear = table_[i].clear_rungs > rung + step;
    errors[i] = std::isfinite(errors[i]) ? std::min(errors[i], most) : is_clear ? most : usual;
  }
  return errors;
}

bool ScaleJudge::HasHalves(const ScaleCandidate& candidate) const {
  const CandidateValues::Column even = values_.Of(candidate, PilotPoint::kEven),
                                odd = values_.Of(candidate, PilotPoint::kOdd);
  size_t known = 0;
  for (size_t i = 0; i < table_.size(); ++i) known += std::isfinite(even.DistanceAt(i, odd)) ? 1 : 0;
  return IsEnough(known, kLeastShareOfHalves, candidate.rung);
}

double ScaleJudge::FloorAt(size_t rung) const {
  const double averaged = std::sqrt(static_cast<double>(kScaleRungs.front()) / kScaleRungs[rung]);
  const double of_mean = kRounding * averaged / median_radii_[rung];
  if (quantity_ != Quantity::kGaussian) return of_mean;
  const double steepest = MedianOf(table_, [rung](const auto& p) { return p.steepest[rung]; });
  return of_mean * std::max(2.0 * (std::isfinite(steepest) ? steepest : 0.0), of_mean);
}

std::vector<double> ScaleJudge::DistancesOf(const CandidateValues::Column& one, const CandidateValues::Column& other) {
  std::vector<double> distances;
  distances.reserve(one.size());
  for (size_t i = 0; i < one.size(); ++i) {
    if (const double distance = one.DistanceAt(i, other); std::isfinite(distance)) distances.push_back(distance);
  }
  return distances;
}

size_t ScaleJudge::ComparedRung(const ScaleCandidate& candidate) const {
  return std::min(candidate.rung, last_compared_[candidate.method]);
}

bool ScaleJudge::IsEnough(size_t count, double share, size_t rung) const {
  return count >= std::min(table_.size(), kLeastPoints) &&
         static_cast<double>(count) >= share * static_cast<double>(clear_counts_[rung]);
}

bool ScaleJudge::IsAllowed(const ScaleCandidate& candidate) const {
  return bounds_.methods[candidate.method] && candidate.count() >= bounds_.least_count &&
         candidate.count() <= bounds_.most_count && median_radii_[candidate.rung] <= bounds_.most_radius;
}

std::optional<double> ScaleJudge::MedianDifference(const ScaleCandidate& candidate, size_t step) const {
  const size_t next = candidate.rung + step;
  if (next >= kRungCount) return std::nullopt;
  const std::vector<double> values = DistancesOf(values_.Of(candidate), values_.Of({candidate.method, next}));
  if (!IsEnough(values.size(), kLeastShare, next)) return std::nullopt;
  return std::max(CutMean(values), kErrorPerDifference * Median(values));
}

void ScaleJudge::AddLastDifferences(size_t method) {
  auto& differences = differences_[method];
  size_t rung = kRungCount;
  while (rung > 0 && !differences[rung - 1].has_value()) --rung;
  last_compared_[method] = rung > 0 ? rung - 1 : 0;
  if (rung < 2) return;
  for (double ratio = 1.0; rung < kRungCount && HasEstimates({method, rung}); ++rung) {
    const auto step = MedianDifference({method, rung}, 1), before = MedianDifference({method, rung - 1}, 1);
    if (step.has_value() && before.has_value() && *before > 0.0) {
      ratio = *step / *before;
    } else if (const auto first = MedianDifference({method, rung - 2}, 1);
               before.has_value() && first.value_or(0.0) > 0.0) {
      ratio = *before / *first;
    }
    differences[rung] = *differences[rung - 1] * ratio;
  }
}

void ScaleJudge::FindNoise() {
  sigma_ = PositionNoise(table_).value_or(0.0);
  size_t best = kResidualRung;
  double least = std::numeric_limits<double>::infinity();
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const std::optional<double>& difference = differences_[kHexagramMethod][rung];
    if (difference.has_value() && *difference < least) {
      least = *difference;
      best = rung;
    }
  }
  // What changes curvatures by a part changes their product by twice that.
  const double factor = quantity_ == Quantity::kGaussian ? 2.0 : 1.0;
  const CandidateValues::Column values = values_.Of({kHexagramMethod, best});
  const double bend = MedianOf(table_, [&](const PilotPoint& p) {
    return factor * values.LengthAt(static_cast<size_t>(&p - table_.data())) * p.steepest[best] * p.steepest[best];
  });
  if (std::isfinite(bend)) noise_bias_ = sigma_ * sigma_ * bend;
}

std::optional<double> ScaleJudge::PositionNoise(PilotPoints table) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t rung = kResidualRung; rung < kRungCount; ++rung) {
    const double residual = MedianOf(table, [&](const auto& p) { return p.residual[rung]; });
    // Neighborhoods hardly larger than the noise leave its outer parts out; detail only adds to it.
    if (std::isfinite(residual) && kLeastRadiusOverNoise * residual <= MedianRadius(table, rung)) {
      least = std::min(least, residual);
    }
  }
  return std::isfinite(least) ? std::optional(least) : std::nullopt;
}

bool ScaleJudge::PositionsAreExact(PilotPoints table) {
  const std::optional<double> sigma = PositionNoise(table);
  return sigma.has_value() && *sigma <= kMostNoiseOfExactPositions * MedianRadius(table, 0);
}

double ScaleJudge::Variance(const ScaleCandidate& candidate) const {
  std::vector<double> values =
      DistancesOf(values_.Of(candidate, PilotPoint::kEven), values_.Of(candidate, PilotPoint::kOdd));
  if (!IsEnough(values.size(), kLeastShareOfHalves, candidate.rung)) return 0.0;
  const double median = Median(std::move(values));
  const double factor =
      quantity_ == Quantity::kTraceless ? kVariancePerSquaredMedianOfVectors : kVariancePerSquaredMedian;
  return 0.25 * factor * median * median;
}

std::optional<ScaleScore> ScaleJudge::FindReference(std::initializer_list<size_t> methods) const {
  std::vector<ScaleScore> without_bias;
  for (const size_t method : methods) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const ScaleCandidate candidate = {method, rung};
      if (differences_[method][rung].has_value() && HasHalves(candidate)) {
        without_bias.push_back(ScoreWithoutBias(candidate));
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
  if (!reference_.has_value() || !PositionsAreExact(table_)) return std::nullopt;
  const std::optional<ScaleScore> jets = FindReference({kQuarticMethod, kSexticMethod});
  if (!jets.has_value() || SquaredBiasOfNormals(jets, reference_->candidate) == 0.0) return std::nullopt;
  return jets;
}

std::optional<double> ScaleJudge::SquaredBias(const ScaleCandidate& candidate, const ScaleCandidate& other) const {
  std::vector<double> products;
  const CandidateValues::Column even = values_.Of(candidate, PilotPoint::kEven),
                                other_even = values_.Of(other, PilotPoint::kEven);
  const CandidateValues::Column odd = values_.Of(candidate, PilotPoint::kOdd),
                                other_odd = values_.Of(other, PilotPoint::kOdd);
  for (size_t i = 0; i < table_.size(); ++i) {
    double product = (even.first[i] - other_even.first[i]) * (odd.first[i] - other_odd.first[i]);
    if (!even.second.empty()) {
      product += (even.second[i] - other_even.second[i]) * (odd.second[i] - other_odd.second[i]);
    }
    if (std::isfinite(product)) products.push_back(product);
  }
  if (!IsEnough(products.size(), kLeastShareOfHalves, std::max(candidate.rung, other.rung))) return std::nullopt;
  const double low = Quantile(products, 1.0 - kProductQuantile), high = Quantile(products, kProductQuantile);
  double sum = 0.0, squares = 0.0;
  for (const double product : products) {
    const double clipped = std::clamp(product, low, high);
    sum += clipped;
    squares += clipped * clipped;
  }
  const double size = static_cast<double>(products.size()), mean = sum / size;
  // Neighborhoods of sampled points overlap: a quarter of the points are independent.
  const double standard_error = std::sqrt(std::max(squares / size - mean * mean, 0.0) / (size / 4.0));
  return mean > kLeastCommon * std::sqrt(squares / size) ? mean - 2.0 * standard_error : 0.0;
}

double ScaleJudge::SquaredBiasBesideSmaller(const ScaleCandidate& candidate) const {
  double most = 0.0;
  for (size_t rung = candidate.rung; rung-- > 0;) {
    const std::optional<double> common = SquaredBias(candidate, {candidate.method, rung});
    if (!common.has_value()) break;
    most = std::max(most, *common);
  }
  return most;
}

double ScaleJudge::SquaredBiasBeside(const std::optional<ScaleScore>& reference,
                                     const ScaleCandidate& candidate) const {
  if (!reference.has_value()) return 0.0;
  // Where a surface is flat at a large scale, all larger ones agree that its Gaussian curvature is 0, a product of two
  // small numbers: by any method.
  const bool looks_farther = quantity_ == Quantity::kGaussian && candidate.rung > reference->candidate.rung;
  if (!kScaleMethods[candidate.method].is_second_order() && !looks_farther) return 0.0;
  const double found = SquaredBias(candidate, reference->candidate).value_or(0.0);
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
    const std::optional<double> common = SquaredBias({candidate.method, rung}, jets->candidate);
    if (!common.has_value()) continue;
    found = *common;
    break;
  }
  return found < kLeastSquareOverJets * jets->error * jets->error ? 0.0 : found - jets->bias * jets->bias;
}

ScaleScore ScaleJudge::ScoreOf(const ScaleCandidate& candidate) const {
  return ScoreOf(candidate, std::max({SquaredBiasBesideSmaller(candidate), SquaredBiasBeside(reference_, candidate),
                                      SquaredBiasOfNormals(reference_of_positions_, candidate),
                                      lost_detail_.SquaredBias(candidate)}));
}

ScaleScore ScaleJudge::ScoreOf(const ScaleCandidate& candidate, double squared_bias) const {
  const std::optional<double>& difference = differences_[candidate.method][candidate.rung];
  const double variance = variances_[candidate.method][candidate.rung];
  const double from_noise = NoiseBias(candidate.method);
  const double known =
      std::sqrt(std::max(*difference * *difference, variance + squared_bias) + from_noise * from_noise);
  const ScaleMethod& method = kScaleMethods[candidate.method];
  const double error = (quantity_ == Quantity::kGaussian ? method.gaussian_doubt : method.doubt) * known;
  return ScaleScore{candidate, error, *difference, std::sqrt(variance), std::sqrt(squared_bias)};
}

ScaleScore ScaleJudge::ScoreWithoutBias(const ScaleCandidate& candidate) const {
  ScaleScore score = ScoreOf(candidate, 0.0);
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

bool ScaleJudge::HasEstimates(const ScaleCandidate& candidate) const {
  const CandidateValues::Column values = values_.Of(candidate);
  const auto known =
      std::count_if(values.first.begin(), values.first.end(), [](double value) { return std::isfinite(value); });
  return IsEnough(static_cast<size_t>(known), kLeastShare, candidate.rung);
}

}  // namespace curvd
