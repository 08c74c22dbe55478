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
constexpr size_t kResidualRung = 4;

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

// Judges candidates by a table of estimates.
class Judge {
 public:
  Judge(const PilotTable& table, const ScaleBounds& bounds) : table_(table), bounds_(bounds) {
    for (size_t m = 0; m < kMethodCount; ++m) {
      for (size_t rung = 0; rung < kRungCount; ++rung) differences_[m][rung] = MedianDifference({m, rung});
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
      AddLastRungs(m, first, scores);
    }
    std::erase_if(scores, [this](const ScaleScore& score) { return !IsAllowed(score.candidate); });
    return scores;
  }

  // What the candidate is expected to be off by at each sampled point, from that point alone.
  std::vector<double> ErrorsAtPoints(const ScaleScore& score) const {
    const size_t step = kScaleMethods[score.candidate.method].compared_rungs;
    size_t rung = score.candidate.rung;  // the last rungs have no next one
    while (rung > 0 && !differences_[score.candidate.method][rung].has_value()) --rung;
    std::vector<double> errors(table_.size()), known;
    for (size_t i = 0; i < table_.size(); ++i) {
      const auto& rungs = table_[i].mean[score.candidate.method];
      errors[i] = rung + step < kRungCount
                      ? std::abs(double{rungs[rung][PilotPoint::kAll]} - rungs[rung + step][PilotPoint::kAll])
                      : std::numeric_limits<double>::quiet_NaN();
      if (std::isfinite(errors[i])) known.push_back(errors[i]);
    }
    if (known.empty()) return std::vector<double>(table_.size(), 1.0);
    const double most = Quantile(std::move(known), kDifferenceQuantile);
    for (double& error : errors) error = std::isfinite(error) ? std::min(error, most) : most;
    return errors;
  }

  double sigma() const { return sigma_; }
  // The least error that can be told at that scale.
  double Floor(size_t rung) const {
    return kRounding / MedianOf([rung](const auto& p) { return p.radius[rung]; });
  }

 private:
  // Of the values that are finite; infinity if there are none.
  template <typename Value>
  double MedianOf(const Value& value) const {
    std::vector<double> values;
    for (const PilotPoint& point : table_) {
      if (const double v = value(point); std::isfinite(v)) values.push_back(v);
    }
    return values.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(values));
  }

  bool IsEnough(size_t count, double share) const {
    return count > 0 && static_cast<double>(count) >= share * static_cast<double>(table_.size());
  }

  bool IsAllowed(const ScaleCandidate& candidate) const {
    return bounds_.methods[candidate.method] && candidate.count() >= bounds_.least_count &&
           candidate.count() <= bounds_.most_count &&
           MedianOf([&](const auto& p) { return p.radius[candidate.rung]; }) <= bounds_.most_radius;
  }

  std::optional<double> MedianDifference(const ScaleCandidate& candidate) const {
    const size_t next = candidate.rung + kScaleMethods[candidate.method].compared_rungs;
    if (next >= kRungCount) return std::nullopt;
    std::vector<double> values;
    for (const PilotPoint& point : table_) {
      const auto& rungs = point.mean[candidate.method];
      const double difference = double{rungs[candidate.rung][PilotPoint::kAll]} - rungs[next][PilotPoint::kAll];
      if (std::isfinite(difference)) values.push_back(std::abs(difference));
    }
    if (!IsEnough(values.size(), kLeastShare)) return std::nullopt;
    return kErrorPerDifference * Median(std::move(values));
  }

  // Noise in the positions: how large, and what it does to an estimate of noise factor 1.
  void FindNoise() {
    size_t best = kResidualRung;
    double least = std::numeric_limits<double>::infinity();
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const std::optional<double>& difference = differences_[kHexagramMethod][rung];
      if (difference.has_value() && *difference < least) {
        least = *difference;
        best = rung;
      }
    }
    const double residual = MedianOf([&](const auto& p) { return p.residual[std::max(best, kResidualRung)]; });
    if (!std::isfinite(residual)) return;
    sigma_ = residual;
    const double bend = MedianOf([&](const PilotPoint& p) {
      return std::abs(double{p.mean[kHexagramMethod][best][PilotPoint::kAll]}) * p.steepest[best] * p.steepest[best];
    });
    if (std::isfinite(bend)) noise_bias_ = sigma_ * sigma_ * bend;
  }

  // The variance of the candidate's estimates that noise makes.
  double Variance(const ScaleCandidate& candidate) const {
    std::vector<double> values;
    for (const PilotPoint& point : table_) {
      const auto& parts = point.mean[candidate.method][candidate.rung];
      const double difference = double{parts[PilotPoint::kEven]} - parts[PilotPoint::kOdd];
      if (std::isfinite(difference)) values.push_back(std::abs(difference));
    }
    if (!IsEnough(values.size(), kLeastShareOfHalves)) return 0.0;
    const double median = Median(std::move(values));
    return 0.25 * kVariancePerSquaredMedian * median * median;
  }

  // The mean of the products of what each half of a neighborhood shows beyond the smaller one, less what chance makes
  // of it: detail that the larger one smooths away is common to both halves, noise is not. None without halves.
  std::optional<double> SquaredBias(const ScaleCandidate& large, size_t small_rung) const {
    std::vector<double> products;
    for (const PilotPoint& point : table_) {
      const auto& at_large = point.mean[large.method][large.rung];
      const auto& at_small = point.mean[large.method][small_rung];
      const double product = (double{at_large[PilotPoint::kEven]} - at_small[PilotPoint::kEven]) *
                             (double{at_large[PilotPoint::kOdd]} - at_small[PilotPoint::kOdd]);
      if (std::isfinite(product)) products.push_back(product);
    }
    if (!IsEnough(products.size(), kLeastShareOfHalves)) return std::nullopt;
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
    const std::optional<double>& difference = differences_[candidate.method][candidate.rung];
    if (!difference.has_value()) return std::nullopt;
    double squared_bias = 0.0;
    for (size_t rung = candidate.rung; rung-- > 0;) {
      const std::optional<double> common = SquaredBias(candidate, rung);
      if (!common.has_value()) break;
      squared_bias = std::max(squared_bias, *common);
    }
    const double variance = Variance(candidate);
    const double from_noise = kScaleMethods[candidate.method].noise_factor * noise_bias_;
    const double error =
        std::sqrt(std::max(*difference * *difference, variance + squared_bias) + from_noise * from_noise);
    return ScaleScore{candidate, error, *difference, std::sqrt(variance), std::sqrt(squared_bias)};
  }

  // The last rungs have no next one to be compared with: where errors fall towards them, they go on falling.
  void AddLastRungs(size_t method, size_t first, std::vector<ScaleScore>& scores) const {
    for (size_t added = 0; added < kScaleMethods[method].compared_rungs; ++added) {
      if (scores.size() < first + 3) return;
      const ScaleScore &last = scores.back(), &before = scores[scores.size() - 3];
      const size_t rung = last.candidate.rung + 1;
      if (rung >= kRungCount || before.candidate.rung + 2 != last.candidate.rung) return;
      if (!(last.error < before.error) || !HasEstimates({method, rung})) return;
      ScaleScore score = last;
      score.candidate.rung = rung;
      score.error *= std::sqrt(last.error / before.error);
      if (last.difference < before.difference) score.difference *= std::sqrt(last.difference / before.difference);
      scores.push_back(score);
    }
  }

  bool HasEstimates(const ScaleCandidate& candidate) const {
    const auto known = std::count_if(table_.begin(), table_.end(), [&](const PilotPoint& point) {
      return std::isfinite(point.mean[candidate.method][candidate.rung][PilotPoint::kAll]);
    });
    return IsEnough(static_cast<size_t>(known), kLeastShare);
  }

  const PilotTable& table_;
  const ScaleBounds& bounds_;
  std::optional<double> differences_[kMethodCount][kRungCount];
  double sigma_ = 0.0, noise_bias_ = 0.0;
};

// The sampled points that lie nearest to each of them.
std::vector<std::vector<size_t>> NearestOfEach(const PilotTable& table) {
  std::vector<std::vector<size_t>> nearest(table.size());
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

// Sets each score's share to its mean weight over the sampled points.
void SetShares(const std::vector<std::vector<double>>& errors, const std::vector<std::vector<size_t>>& nearest,
               std::vector<ScaleScore>& scores) {
  std::vector<double> weights(scores.size());
  for (const std::vector<size_t>& near : nearest) {
    for (size_t s = 0; s < scores.size(); ++s) {
      double sum = 0.0;
      for (const size_t i : near) sum += errors[s][i];
      weights[s] = ScaleWeight(sum / static_cast<double>(near.size()));
    }
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (size_t s = 0; s < scores.size(); ++s)
      scores[s].share += weights[s] / total / static_cast<double>(nearest.size());
  }
}

}  // namespace

double ScaleWeight(double error) { return 1.0 / (error * error * error * error); }

ScaleChoice ChooseScales(const PilotTable& table, const ScaleBounds& bounds) {
  ScaleChoice choice;
  if (table.empty()) return choice;
  const Judge judge(table, bounds);
  choice.scores = judge.Scores();
  choice.sigma = judge.sigma();
  std::vector<ScaleScore>& scores = choice.scores;
  if (scores.empty()) return choice;
  std::vector<std::vector<double>> errors;
  for (ScaleScore& score : scores) {
    const double floor = judge.Floor(score.candidate.rung);
    score.error = std::max(score.error, floor);
    score.difference = std::max(score.difference, floor);
    if (bounds.per_cloud) {
      errors.emplace_back(table.size(), score.error);
      continue;
    }
    errors.push_back(judge.ErrorsAtPoints(score));
    for (double& error : errors.back()) error = std::max(error * (score.error / score.difference), floor);
  }
  SetShares(errors, NearestOfEach(table), scores);

  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a].share > scores[b].share; });
  for (size_t rank = ScaleChoice::kMostChosen; rank < order.size(); ++rank) scores[order[rank]].share = 0.0;
  order.resize(std::min(order.size(), ScaleChoice::kMostChosen));
  double total = 0.0;
  for (const size_t s : order) total += scores[s].share;
  for (const size_t s : order) {
    scores[s].share /= total;
    choice.chosen.push_back(scores[s].candidate);
    choice.cloud_weights.push_back(scores[s].share);
  }
  if (bounds.per_cloud) return choice;
  choice.local_errors.resize(table.size());
  for (size_t i = 0; i < table.size(); ++i) {
    for (size_t c = 0; c < order.size(); ++c) choice.local_errors[i][c] = static_cast<float>(errors[order[c]][i]);
  }
  return choice;
}

}  // namespace curvd
