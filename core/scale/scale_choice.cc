#include "core/scale/scale_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

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

// Which curvature candidates are judged by.
enum class Quantity : uint8_t { kMean, kGaussian };

// Judges candidates by a table of estimates.
class Judge {
 public:
  Judge(const PilotTable& table, const ScaleBounds& bounds, Quantity quantity)
      : table_(table), bounds_(bounds), quantity_(quantity) {
    for (size_t m = 0; m < kMethodCount; ++m) {
      const size_t step = kScaleMethods[m].compared_rungs;
      for (size_t rung = 0; rung < kRungCount; ++rung) differences_[m][rung] = MedianDifference({m, rung}, step);
      AddLastDifferences(m);
    }
    FindNoise();
  }

  std::vector<ScaleScore> Scores() const {
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

  // The scores of candidates that were judged by the mean curvature. Their biases are as large beside the differences
  // as there: noise in a small neighborhood moves the Gaussian curvature of both halves to one side, as detail would.
  std::vector<ScaleScore> ScoresOf(const std::vector<ScaleScore>& of_mean) const {
    std::vector<ScaleScore> scores;
    for (const ScaleScore& mean : of_mean) {
      const ScaleCandidate& candidate = mean.candidate;
      const double difference = *differences_[candidate.method][candidate.rung];
      const double bias = mean.difference > 0.0 ? mean.bias * difference / mean.difference : 0.0;
      scores.push_back(ScoreOf(candidate, bias * bias));
    }
    return scores;
  }

  // By how much the candidate's estimate, and that of the next larger scale, differ at each sampled point.
  std::vector<double> DifferencesAtPoints(const ScaleScore& score, PilotPoint::Part part = PilotPoint::kAll) const {
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

  // What the differences at points come to over the cloud.
  double CloudDifference(const ScaleScore& score) const {
    return *differences_[score.candidate.method][ComparedRung(score.candidate)];
  }

  // Whether the halves of neighborhoods, too, have estimates at nearly all points.
  bool HasHalves(const ScaleCandidate& candidate) const {
    const auto known = std::count_if(table_.begin(), table_.end(), [&](const PilotPoint& point) {
      return std::isfinite(ValueAt(point, candidate.method, candidate.rung, PilotPoint::kEven) +
                           ValueAt(point, candidate.method, candidate.rung, PilotPoint::kOdd));
    });
    return IsEnough(static_cast<size_t>(known), kLeastShareOfHalves, candidate.rung);
  }

  double sigma() const { return sigma_; }
  // The least error that can be told at that scale.
  double Floor(size_t rung) const {
    const double of_mean = kRounding / MedianRadius(rung);
    if (quantity_ == Quantity::kMean) return of_mean;
    const double steepest = MedianOf([rung](const auto& p) { return p.steepest[rung]; });
    return of_mean * std::max(2.0 * (std::isfinite(steepest) ? steepest : 0.0), of_mean);
  }
  double MedianRadius(size_t rung) const {
    return MedianOf([rung](const auto& p) { return p.radius[rung]; });
  }

 private:
  double ValueAt(const PilotPoint& point, size_t method, size_t rung, PilotPoint::Part part = PilotPoint::kAll) const {
    const double mean = point.mean[method][rung][part];
    if (quantity_ == Quantity::kMean) return mean;
    const double difference = point.difference[method][rung][part], twist = point.twist[method][rung][part];
    return mean * mean - difference * difference - twist * twist;
  }
  double Difference(const PilotPoint& point, size_t method, size_t rung, size_t other,
                    PilotPoint::Part part = PilotPoint::kAll) const {
    return ValueAt(point, method, rung, part) - ValueAt(point, method, other, part);
  }

  // The rung itself, unless it has no next one to be compared with.
  size_t ComparedRung(const ScaleCandidate& candidate) const {
    return std::min(candidate.rung, last_compared_[candidate.method]);
  }

  // Of the values that are finite; infinity if there are none.
  template <typename Value>
  double MedianOf(const Value& value) const {
    std::vector<double> values;
    for (const PilotPoint& point : table_) {
      if (const double v = value(point); std::isfinite(v)) values.push_back(v);
    }
    return values.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(values));
  }

  // Of the points whose neighborhoods at that rung reach over no edge.
  bool IsEnough(size_t count, double share, size_t rung) const {
    const auto clear = std::count_if(table_.begin(), table_.end(),
                                     [rung](const PilotPoint& point) { return point.clear_rungs > rung; });
    return count >= std::min(table_.size(), kLeastPoints) &&
           static_cast<double>(count) >= share * static_cast<double>(clear);
  }

  bool IsAllowed(const ScaleCandidate& candidate) const {
    return bounds_.methods[candidate.method] && candidate.count() >= bounds_.least_count &&
           candidate.count() <= bounds_.most_count && MedianRadius(candidate.rung) <= bounds_.most_radius;
  }

  // By how much estimates differ from those so many rungs on, as an error.
  std::optional<double> MedianDifference(const ScaleCandidate& candidate, size_t step) const {
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

  // The last rungs have no next one to be compared with: their differences go on as those of single steps do.
  void AddLastDifferences(size_t method) {
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

  // Noise in the positions: how large, and what it does to an estimate of noise factor 1.
  void FindNoise() {
    size_t best = kResidualRung;
    double least = std::numeric_limits<double>::infinity(), residual = least;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const std::optional<double>& difference = differences_[kHexagramMethod][rung];
      if (difference.has_value() && *difference < least) {
        least = *difference;
        best = rung;
      }
      // Detail only adds to the noise.
      if (rung >= kResidualRung)
        residual = std::min(residual, MedianOf([&](const auto& p) { return p.residual[rung]; }));
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

  // The noise of positions as neighborhoods of that size show it; detail only adds to it. None where they are hardly
  // larger than the noise, whose outer parts they then leave out.
  std::optional<double> ResidualAt(size_t rung) const {
    if (rung < kResidualRung) return std::nullopt;
    const double residual = MedianOf([&](const auto& p) { return p.residual[rung]; });
    if (!std::isfinite(residual) || kLeastRadiusOverNoise * residual > MedianRadius(rung)) return std::nullopt;
    return residual;
  }

  // The variance of the candidate's estimates that noise makes.
  double Variance(const ScaleCandidate& candidate) const {
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

  // The mean of the products of what each half of a neighborhood shows beyond the smaller one, less what chance makes
  // of it: detail that the larger one smooths away is common to both halves, noise is not. None without halves.
  std::optional<double> SquaredBias(const ScaleCandidate& large, size_t small_rung) const {
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

  std::optional<ScaleScore> ScoreOf(const ScaleCandidate& candidate) const {
    if (!differences_[candidate.method][candidate.rung].has_value()) return std::nullopt;
    double squared_bias = 0.0;
    for (size_t rung = candidate.rung; rung-- > 0;) {
      const std::optional<double> common = SquaredBias(candidate, rung);
      if (!common.has_value()) break;
      squared_bias = std::max(squared_bias, *common);
    }
    return ScoreOf(candidate, squared_bias);
  }

  ScaleScore ScoreOf(const ScaleCandidate& candidate, double squared_bias) const {
    const std::optional<double>& difference = differences_[candidate.method][candidate.rung];
    const double variance = Variance(candidate);
    const double from_noise = kScaleMethods[candidate.method].noise_factor * noise_bias_;
    const double error =
        std::sqrt(std::max(*difference * *difference, variance + squared_bias) + from_noise * from_noise);
    return ScaleScore{candidate, error, *difference, std::sqrt(variance), std::sqrt(squared_bias)};
  }

  // A difference tells the larger one of two errors. Where they rise from the first rung on, so that noise does not
  // matter, that of the first rung is the second one's, and its own is found as it would be at the other end.
  static void MendFirstRung(size_t first, std::vector<ScaleScore>& scores) {
    if (scores.size() < first + 4) return;
    ScaleScore& score = scores[first];
    const ScaleScore &next = scores[first + 1], &later = scores[first + 3];
    if (later.candidate.rung != score.candidate.rung + 3) return;
    if (!(score.error < next.error && next.error < scores[first + 2].error && scores[first + 2].error < later.error))
      return;
    score.error = std::min(score.error, next.error * std::sqrt(next.error / later.error));
  }

  bool HasEstimates(const ScaleCandidate& candidate) const {
    const auto known = std::count_if(table_.begin(), table_.end(), [&](const PilotPoint& point) {
      return std::isfinite(ValueAt(point, candidate.method, candidate.rung));
    });
    return IsEnough(static_cast<size_t>(known), kLeastShare, candidate.rung);
  }

  const PilotTable& table_;
  const ScaleBounds bounds_;
  const Quantity quantity_;
  std::optional<double> differences_[kMethodCount][kRungCount];
  size_t last_compared_[kMethodCount] = {};  // the last rung that has a next one
  double sigma_ = 0.0, noise_bias_ = 0.0;
};

// Of each sampled point, the places of those that lie nearest to it.
using Neighbors = std::vector<std::vector<size_t>>;

Neighbors NearestOfEach(const PilotTable& table) {
  Neighbors nearest(table.size());
  std::vector<size_t> order(table.size());
  std::vector<float> squared(table.size());
  const size_t count = std::min(ScaleChoice::kNearest, table.size());
  for (size_t i = 0; i < table.size(); ++i) {
    for (size_t j = 0; j < table.size(); ++j) {
      squared[j] = 0.0f;
      for (size_t axis = 0; axis < 3; ++axis) {
        const float d = table[j].position[axis] - table[i].position[axis];
        squared[j] += d * d;
      }
    }
    std::iota(order.begin(), order.end(), size_t{0});
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count - 1), order.end(),
                     [&](size_t a, size_t b) { return squared[a] != squared[b] ? squared[a] < squared[b] : a < b; });
    nearest[i].assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
    std::sort(nearest[i].begin(), nearest[i].end());
  }
  return nearest;
}

// The mean of the values of those that lie nearest to each.
std::vector<double> MeansOfNearest(const std::vector<double>& values, const Neighbors& nearest) {
  std::vector<double> means;
  for (const std::vector<size_t>& near : nearest) {
    double sum = 0.0;
    for (const size_t i : near) sum += values[i];
    means.push_back(sum / static_cast<double>(near.size()));
  }
  return means;
}

// How far two measurements of one thing at many places, each with errors of its own, can be relied on when they are
// taken together: the share of the variance of the logarithms of both that they have in common (Spearman and Brown).
double RelianceOn(const std::vector<double>& one, const std::vector<double>& other) {
  double sum[2] = {}, squares[2] = {}, products = 0.0;
  for (size_t i = 0; i < one.size(); ++i) {
    const double logarithms[2] = {std::log(one[i]), std::log(other[i])};
    for (size_t k = 0; k < 2; ++k) {
      sum[k] += logarithms[k];
      squares[k] += logarithms[k] * logarithms[k];
    }
    products += logarithms[0] * logarithms[1];
  }
  const double size = static_cast<double>(one.size());
  const double variances = (squares[0] - sum[0] * sum[0] / size) * (squares[1] - sum[1] * sum[1] / size);
  const double covariance = products - sum[0] * sum[1] / size;
  if (!(variances > 0.0) || !(covariance > 0.0)) return 0.0;
  const double found = std::min(covariance / std::sqrt(variances), 1.0);
  // Means that have no point in common are independent: the correlation is known to this standard error.
  const double parts = size / static_cast<double>(ScaleChoice::kNearest);
  const double correlation = std::max(found - (1.0 - found * found) / std::sqrt(std::max(parts, 1.0)), 0.0);
  return 2.0 * correlation / (1.0 + correlation);
}

// What one quantity says of every candidate.
struct Judged {
  std::vector<ScaleScore> scores;
  std::vector<std::vector<double>> differences;  // of each candidate, at each sampled point
  std::vector<LocalTrend> trends;                // of each candidate
  std::vector<double> shares;                    // of each candidate: its mean weight over the sampled points
};

// How far the trend of a candidate can be relied on: that of the first scale from it on whose neighborhoods have
// halves.
double Reliance(const Judge& judge, ScaleScore score, double floor, const Neighbors& nearest) {
  std::vector<double> means[2];
  for (size_t rung = score.candidate.rung; rung < kRungCount; ++rung) {
    score.candidate.rung = rung;
    if (!judge.HasHalves(score.candidate)) continue;
    for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd}) {
      std::vector<double> differences = judge.DifferencesAtPoints(score, part);
      for (double& difference : differences) difference = std::max(difference, floor);
      means[part - PilotPoint::kEven] = MeansOfNearest(differences, nearest);
    }
    return RelianceOn(means[0], means[1]);
  }
  return 1.0;
}

Judged JudgeAt(const Judge& judge, std::vector<ScaleScore> scores, const Neighbors& nearest, bool per_cloud) {
  Judged judged;
  std::vector<std::vector<double>> means;
  for (ScaleScore& score : scores) {
    const double floor = judge.Floor(score.candidate.rung);
    score.error = std::max(score.error, floor);
    score.difference = std::max(score.difference, floor);
    std::vector<double> differences = judge.DifferencesAtPoints(score);
    for (double& difference : differences) difference = std::max(difference, floor);
    means.push_back(MeansOfNearest(differences, nearest));
    const double difference = std::max(judge.CloudDifference(score), floor);
    judged.trends.push_back({score.error, difference, per_cloud ? 0.0 : Reliance(judge, score, floor, nearest)});
    judged.differences.push_back(std::move(differences));
  }
  judged.shares.resize(scores.size());
  std::vector<double> weights(scores.size());
  for (size_t i = 0; i < nearest.size(); ++i) {
    for (size_t s = 0; s < scores.size(); ++s) weights[s] = ScaleWeight(judged.trends[s].ErrorAt(means[s][i]));
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (size_t s = 0; s < scores.size(); ++s) {
      judged.shares[s] += weights[s] / total / static_cast<double>(nearest.size());
    }
  }
  judged.scores = std::move(scores);
  return judged;
}

// Of the chosen candidates alone, in their order.
ScaleWeights WeightsOf(const Judged& judged, const std::vector<size_t>& chosen, bool per_cloud) {
  ScaleWeights weights;
  double total = 0.0;
  for (const size_t s : chosen) total += judged.shares[s];
  for (const size_t s : chosen) weights.cloud_weights.push_back(judged.shares[s] / total);
  if (per_cloud) return weights;
  for (const size_t s : chosen) weights.trends.push_back(judged.trends[s]);
  weights.local_differences.resize(judged.differences.front().size());
  for (size_t i = 0; i < weights.local_differences.size(); ++i) {
    for (size_t c = 0; c < chosen.size(); ++c) {
      weights.local_differences[i][c] = static_cast<float>(judged.differences[chosen[c]][i]);
    }
  }
  return weights;
}

}  // namespace

double PositionNoise(const PilotTable& table) { return Judge(table, {}, Quantity::kMean).sigma(); }

double ScaleWeight(double error) { return 1.0 / (error * error * error * error); }

double LocalTrend::ErrorAt(double difference) const {
  return cloud_error * std::pow(difference / cloud_difference, reliance);
}

ScaleChoice ChooseScales(const PilotTable& table, const ScaleBounds& bounds) {
  ScaleChoice choice;
  if (table.empty()) return choice;
  const Judge of_mean(table, bounds, Quantity::kMean), of_gaussian(table, bounds, Quantity::kGaussian);
  choice.scores = of_mean.Scores();
  choice.sigma = of_mean.sigma();
  if (choice.scores.empty()) return choice;
  const Neighbors nearest = NearestOfEach(table);
  const Judged mean = JudgeAt(of_mean, choice.scores, nearest, bounds.per_cloud);
  const Judged gaussian = JudgeAt(of_gaussian, of_gaussian.ScoresOf(choice.scores), nearest, bounds.per_cloud);

  std::vector<size_t> order(choice.scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto share = [&](size_t s) { return mean.shares[s] + gaussian.shares[s]; };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return share(a) > share(b); });
  order.resize(std::min(order.size(), ScaleChoice::kMostChosen));
  choice.mean = WeightsOf(mean, order, bounds.per_cloud);
  choice.gaussian = WeightsOf(gaussian, order, bounds.per_cloud);
  choice.scores = mean.scores;
  for (size_t c = 0; c < order.size(); ++c) {
    choice.chosen.push_back(choice.scores[order[c]].candidate);
    choice.scores[order[c]].share = choice.mean.cloud_weights[c];
  }
  return choice;
}

}  // namespace curvd
