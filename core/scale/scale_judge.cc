#include "core/scale/scale_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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
// Differences at single points beyond this quantile are cut down to it.
constexpr double kDifferenceQuantile = 0.99;
// Rounding of normals to float32 moves curvature by about this many times 1 / radius: no difference says less.
constexpr double kRounding = 1e-6;
// The rung from which the residual of a jet of degree 4 tells the noise.
constexpr size_t kResidualRung = 2;
// Noise is told from the surface in neighborhoods that are so many times larger.
constexpr double kLeastRadiusOverNoise = 4.0;

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

}  // namespace

ScaleJudge::ScaleJudge(const PilotTable& table, const ScaleBounds& bounds, Quantity quantity)
    : table_(table), bounds_(bounds), quantity_(quantity) {
  for (size_t m = 0; m < kMethodCount; ++m) {
    const size_t step = kScaleMethods[m].compared_rungs;
    for (size_t rung = 0; rung < kRungCount; ++rung) differences_[m][rung] = MedianDifference({m, rung}, step);
    AddLastDifferences(m);
  }
  FindNoise();
}

std::vector<ScaleScore> ScaleJudge::Scores() const {
  std::vector<ScaleScore> scores;
  for (size_t m = 0; m < kMethodCount; ++m) {
    const size_t first = scores.size();
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      if (const auto score = ScoreOf({m, rung})) scores.push_back(*score);
    }
    MendFirstRung(first, scores);
  }
  std::erase_if(scores, [this](const ScaleScore& score) { return !IsAllowed(score.candidate); });
  return scores;
}

std::vector<ScaleScore> ScaleJudge::ScoresOf(const std::vector<ScaleScore>& of_mean) const {
  std::vector<ScaleScore> scores;
  for (const ScaleScore& mean : of_mean) {
    const ScaleCandidate& candidate = mean.candidate;
    const double difference = *differences_[candidate.method][candidate.rung];
    const double bias = mean.difference > 0.0 ? mean.bias * difference / mean.difference : 0.0;
    scores.push_back(ScoreOf(candidate, bias * bias));
  }
  return scores;
}

std::vector<double> ScaleJudge::DifferencesAtPoints(const ScaleScore& score, PilotPoint::Part part) const {
  const size_t step = kScaleMethods[score.candidate.method].compared_rungs;
  const size_t rung = ComparedRung(score.candidate);
  std::vector<double> errors(table_.size()), known;
  for (size_t i = 0; i < table_.size(); ++i) {
    errors[i] = rung + step < kRungCount
                    ? std::abs(Difference(table_[i], score.candidate.method, rung, rung + step, part))
                    : std::numeric_limits<double>::quiet_NaN();
    if (std::isfinite(errors[i])) known.push_back(errors[i]);
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
  const auto known = std::count_if(table_.begin(), table_.end(), [&](const PilotPoint& point) {
    return std::isfinite(ValueAt(point, candidate.method, candidate.rung, PilotPoint::kEven) +
                         ValueAt(point, candidate.method, candidate.rung, PilotPoint::kOdd));
  });
  return IsEnough(static_cast<size_t>(known), kLeastShareOfHalves, candidate.rung);
}

double ScaleJudge::Floor(size_t rung) const {
  const double of_mean = kRounding / MedianRadius(rung);
  if (quantity_ == Quantity::kMean) return of_mean;
  const double steepest = MedianOf([rung](const auto& p) { return p.steepest[rung]; });
  return of_mean * std::max(2.0 * (std::isfinite(steepest) ? steepest : 0.0), of_mean);
}

double ScaleJudge::MedianRadius(size_t rung) const {
  return MedianOf([rung](const auto& p) { return p.radius[rung]; });
}

double ScaleJudge::ValueAt(const PilotPoint& point, size_t method, size_t rung, PilotPoint::Part part) const {
  const double mean = point.mean[method][rung][part];
  if (quantity_ == Quantity::kMean) return mean;
  const double difference = point.difference[method][rung][part], twist = point.twist[method][rung][part];
  return mean * mean - difference * difference - twist * twist;
}

size_t ScaleJudge::ComparedRung(const ScaleCandidate& candidate) const {
  return std::min(candidate.rung, last_compared_[candidate.method]);
}

template <typename Value>
double ScaleJudge::MedianOf(const Value& value) const {
  std::vector<double> values;
  for (const PilotPoint& point : table_) {
    if (const double v = value(point); std::isfinite(v)) values.push_back(v);
  }
  return values.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(values));
}

bool ScaleJudge::IsEnough(size_t count, double share, size_t rung) const {
  const auto clear =
      std::count_if(table_.begin(), table_.end(), [rung](const PilotPoint& point) { return point.clear_rungs > rung; });
  return count >= std::min(table_.size(), kLeastPoints) &&
         static_cast<double>(count) >= share * static_cast<double>(clear);
}

bool ScaleJudge::IsAllowed(const ScaleCandidate& candidate) const {
  return bounds_.methods[candidate.method] && candidate.count() >= bounds_.least_count &&
         candidate.count() <= bounds_.most_count && MedianRadius(candidate.rung) <= bounds_.most_radius;
}

std::optional<double> ScaleJudge::MedianDifference(const ScaleCandidate& candidate, size_t step) const {
  const size_t next = candidate.rung + step;
  if (next >= kRungCount) return std::nullopt;
  std::vector<double> values;
  for (const PilotPoint& point : table_) {
    const double difference = Difference(point, candidate.method, candidate.rung, next);
    if (std::isfinite(difference)) values.push_back(std::abs(difference));
  }
  if (!IsEnough(values.size(), kLeastShare, next)) return std::nullopt;
  return kErrorPerDifference * Median(std::move(values));
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
  size_t best = kResidualRung;
  double least = std::numeric_limits<double>::infinity(), residual = least;
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const std::optional<double>& difference = differences_[kHexagramMethod][rung];
    if (difference.has_value() && *difference < least) {
      least = *difference;
      best = rung;
    }
    // Detail only adds to the noise.
    if (const auto at_rung = ResidualAt(rung)) residual = std::min(residual, *at_rung);
  }
  if (!std::isfinite(residual)) return;
  sigma_ = residual;
  // What changes curvatures by a part changes their product by twice that.
  const double factor = quantity_ == Quantity::kMean ? 1.0 : 2.0;
  const double bend = MedianOf([&](const PilotPoint& p) {
    return factor * std::abs(ValueAt(p, kHexagramMethod, best)) * p.steepest[best] * p.steepest[best];
  });
  if (std::isfinite(bend)) noise_bias_ = sigma_ * sigma_ * bend;
}

std::optional<double> ScaleJudge::ResidualAt(size_t rung) const {
  if (rung < kResidualRung) return std::nullopt;
  const double residual = MedianOf([&](const auto& p) { return p.residual[rung]; });
  if (!std::isfinite(residual) || kLeastRadiusOverNoise * residual > MedianRadius(rung)) return std::nullopt;
  return residual;
}

double ScaleJudge::Variance(const ScaleCandidate& candidate) const {
  std::vector<double> values;
  for (const PilotPoint& point : table_) {
    const double difference = ValueAt(point, candidate.method, candidate.rung, PilotPoint::kEven) -
                              ValueAt(point, candidate.method, candidate.rung, PilotPoint::kOdd);
    if (std::isfinite(difference)) values.push_back(std::abs(difference));
  }
  if (!IsEnough(values.size(), kLeastShareOfHalves, candidate.rung)) return 0.0;
  const double median = Median(std::move(values));
  return 0.25 * kVariancePerSquaredMedian * median * median;
}

std::optional<double> ScaleJudge::SquaredBias(const ScaleCandidate& large, size_t small_rung) const {
  std::vector<double> products;
  for (const PilotPoint& point : table_) {
    const double product = Difference(point, large.method, large.rung, small_rung, PilotPoint::kEven) *
                           Difference(point, large.method, large.rung, small_rung, PilotPoint::kOdd);
    if (std::isfinite(product)) products.push_back(product);
  }
  if (!IsEnough(products.size(), kLeastShareOfHalves, large.rung)) return std::nullopt;
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
  return mean - 2.0 * standard_error;
}

std::optional<ScaleScore> ScaleJudge::ScoreOf(const ScaleCandidate& candidate) const {
  if (!differences_[candidate.method][candidate.rung].has_value()) return std::nullopt;
  double squared_bias = 0.0;
  for (size_t rung = candidate.rung; rung-- > 0;) {
    const std::optional<double> common = SquaredBias(candidate, rung);
    if (!common.has_value()) break;
    squared_bias = std::max(squared_bias, *common);
  }
  return ScoreOf(candidate, squared_bias);
}

ScaleScore ScaleJudge::ScoreOf(const ScaleCandidate& candidate, double squared_bias) const {
  const std::optional<double>& difference = differences_[candidate.method][candidate.rung];
  const double variance = Variance(candidate);
  const double from_noise = kScaleMethods[candidate.method].noise_factor * noise_bias_;
  const double error =
      std::sqrt(std::max(*difference * *difference, variance + squared_bias) + from_noise * from_noise);
  return ScaleScore{candidate, error, *difference, std::sqrt(variance), std::sqrt(squared_bias)};
}

void ScaleJudge::MendFirstRung(size_t first, std::vector<ScaleScore>& scores) {
  if (scores.size() < first + 4) return;
  ScaleScore& score = scores[first];
  const ScaleScore &next = scores[first + 1], &later = scores[first + 3];
  if (later.candidate.rung != score.candidate.rung + 3) return;
  if (!(score.error < next.error && next.error < scores[first + 2].error && scores[first + 2].error < later.error))
    return;
  score.error = std::min(score.error, next.error * std::sqrt(next.error / later.error));
}

bool ScaleJudge::HasEstimates(const ScaleCandidate& candidate) const {
  const auto known = std::count_if(table_.begin(), table_.end(), [&](const PilotPoint& point) {
    return std::isfinite(ValueAt(point, candidate.method, candidate.rung));
  });
  return IsEnough(static_cast<size_t>(known), kLeastShare, candidate.rung);
}

}  // namespace curvd
