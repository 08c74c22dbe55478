#include "core/scale/scale_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/scale/scale_judge.h"

namespace curvd {
namespace {

// Of each sampled point, the places of those that lie nearest to it.
using Neighbors = std::vector<std::vector<size_t>>;

Neighbors NearestOfEach(PilotPoints table) {
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
  std::vector<std::vector<double>> weights;      // of each candidate, at each sampled point; 1 in all at a point
  std::vector<double> shares;                    // of each candidate: its mean weight over the sampled points
};

// How far the trend of a candidate can be relied on: that of the first scale from it on whose neighborhoods have
// halves.
double Reliance(const ScaleJudge& judge, ScaleScore score, double floor, const Neighbors& nearest) {
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

Judged JudgeAt(const ScaleJudge& judge, std::vector<ScaleScore> scores, const Neighbors& nearest, bool per_cloud) {
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
  judged.weights.assign(scores.size(), std::vector<double>(nearest.size()));
  for (size_t i = 0; i < nearest.size(); ++i) {
    double total = 0.0;
    for (size_t s = 0; s < scores.size(); ++s) {
      judged.weights[s][i] = ScaleWeight(judged.trends[s].ErrorAt(means[s][i]));
      total += judged.weights[s][i];
    }
    for (size_t s = 0; s < scores.size(); ++s) {
      judged.weights[s][i] /= total;
      judged.shares[s] += judged.weights[s][i] / static_cast<double>(nearest.size());
    }
  }
  judged.scores = std::move(scores);
  return judged;
}

// How many times the error of all candidates' average the average of some errs, who have this part of the weight at a
// point.
double ErrorBesideAll(double weight) {
  constexpr double kLeast = 1e-12;
  return 1.0 / std::sqrt(std::sqrt(std::max(weight, kLeast)));
}

// Of the candidates from `first` on, the place of that which adds the most to the mean curvature's estimate by those
// before it, over all sampled points.
size_t BestAddition(const Judged& mean, const std::vector<size_t>& candidates, size_t first) {
  std::vector<double> sums(mean.weights.front().size());
  for (size_t c = 0; c < first; ++c) {
    for (size_t i = 0; i < sums.size(); ++i) sums[i] += mean.weights[candidates[c]][i];
  }
  double least = std::numeric_limits<double>::infinity();
  size_t best = first;
  for (size_t c = first; c < candidates.size(); ++c) {
    double error = 0.0;
    for (size_t i = 0; i < sums.size(); ++i) error += ErrorBesideAll(sums[i] + mean.weights[candidates[c]][i]);
    if (error < least) {
      least = error;
      best = c;
    }
  }
  return best;
}

// At most kMostChosen candidates, those with the largest shares first. The last one is that which adds the most to the
// others: where a part of the cloud is noisier, or sparser, these may all suit the rest of it.
std::vector<size_t> ChooseTogether(const Judged& mean, const Judged& gaussian) {
  std::vector<size_t> order(mean.scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto share = [&](size_t s) { return mean.shares[s] + gaussian.shares[s]; };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return share(a) > share(b); });
  if (order.size() <= ScaleChoice::kMostChosen) return order;
  constexpr size_t kLast = ScaleChoice::kMostChosen - 1;
  order[kLast] = order[BestAddition(mean, order, kLast)];
  order.resize(ScaleChoice::kMostChosen);
  return order;
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

// Jets of degree 6 cost the most: they are chosen only if they are expected to err less than all others times this.
// What a few points expect of them may be off by a factor of two to three.
constexpr double kWorthwhile = 0.7, kWorthwhileToFew = 2.0;

void DropUnlessWorthwhile(double worthwhile, std::vector<ScaleScore>& scores) {
  double least = std::numeric_limits<double>::infinity(), least_of_sextic = least;
  for (const ScaleScore& score : scores) {
    double& of_kind = score.candidate.method == kSexticMethod ? least_of_sextic : least;
    of_kind = std::min(of_kind, score.error);
  }
  if (least_of_sextic <= worthwhile * least) return;
  std::erase_if(scores, [](const ScaleScore& score) { return score.candidate.method == kSexticMethod; });
}

// What both quantities say; no scores: none can be judged.
struct BothJudged {
  Judged mean, gaussian;
  double sigma;  // noise of the positions
};

BothJudged JudgeBoth(PilotPoints table, const ScaleBounds& bounds, double worthwhile) {
  const ScaleJudge of_mean(table, bounds, ScaleJudge::Quantity::kMean),
      of_gaussian(table, bounds, ScaleJudge::Quantity::kGaussian);
  std::vector<ScaleScore> scores = of_mean.Scores();
  DropUnlessWorthwhile(worthwhile, scores);
  if (scores.empty()) return {{}, {}, of_mean.sigma()};
  const Neighbors nearest = NearestOfEach(table);
  Judged gaussian = JudgeAt(of_gaussian, of_gaussian.ScoresOf(scores, of_mean), nearest, bounds.per_cloud);
  return {JudgeAt(of_mean, std::move(scores), nearest, bounds.per_cloud), std::move(gaussian), of_mean.sigma()};
}

}  // namespace

double PositionNoise(PilotPoints table) { return ScaleJudge::PositionNoise(table); }

double ScaleWeight(double error) { return 1.0 / (error * error * error * error); }

double LocalTrend::ErrorAt(double difference) const {
  return cloud_error * std::pow(difference / cloud_difference, reliance);
}

std::optional<CandidatesThatCount> FindCandidatesThatCount(PilotPoints table, const ScaleBounds& bounds,
                                                           double least_weight) {
  if (table.empty()) return std::nullopt;
  const BothJudged judged = JudgeBoth(table, bounds, kWorthwhileToFew);
  std::optional<CandidatesThatCount> found;
  for (const Judged* of : {&judged.mean, &judged.gaussian}) {
    for (size_t c = 0; c < of->scores.size(); ++c) {
      const std::vector<double>& weights = of->weights[c];
      if (!(*std::max_element(weights.begin(), weights.end()) >= least_weight)) continue;
      if (!found.has_value()) found.emplace();
      const ScaleCandidate& candidate = of->scores[c].candidate;
      found->largest_rung = std::max(found->largest_rung, candidate.rung);
      found->methods[candidate.method] = true;
    }
  }
  return found;
}

// For each quantity, what its judge holds, and of each candidate the difference, its mean around the point and a
// weight; for both the nearest points.
size_t ChoosingBytesPerSample() {
  constexpr size_t kOfCandidate = 3 * sizeof(double);
  return 2 * (ScaleJudge::kBytesPerSample + kMethodCount * kRungCount * kOfCandidate) +
         ScaleChoice::kNearest * sizeof(size_t) + sizeof(Neighbors::value_type);
}

ScaleChoice ChooseScales(PilotPoints table, const ScaleBounds& bounds) {
  ScaleChoice choice;
  if (table.empty()) return choice;
  const BothJudged judged = JudgeBoth(table, bounds, kWorthwhile);
  choice.sigma = judged.sigma;
  choice.scores = judged.mean.scores;
  if (choice.scores.empty()) return choice;
  const std::vector<size_t> order = ChooseTogether(judged.mean, judged.gaussian);
  choice.mean = WeightsOf(judged.mean, order, bounds.per_cloud);
  choice.gaussian = WeightsOf(judged.gaussian, order, bounds.per_cloud);
  for (size_t c = 0; c < order.size(); ++c) {
    choice.chosen.push_back(choice.scores[order[c]].candidate);
    choice.scores[order[c]].share = choice.mean.cloud_weights[c];
  }
  return choice;
}

double LeastLocalError(const ScaleChoice& choice) {
  const auto is_doubted = [](const ScaleScore& score) { return kScaleMethods[score.candidate.method].is_doubted(); };
  const auto is_chosen = [](const ScaleScore& score) { return score.share > 0.0; };
  const bool any_is_doubted = std::any_of(choice.scores.begin(), choice.scores.end(), [&](const ScaleScore& score) {
    return is_doubted(score) && is_chosen(score);
  });
  double of_chosen = std::numeric_limits<double>::infinity(), of_others = of_chosen;
  for (const ScaleScore& score : choice.scores) {
    if (is_chosen(score)) of_chosen = std::min(of_chosen, score.error);
    if (!is_doubted(score)) of_others = std::min(of_others, score.error);
  }
  return any_is_doubted && std::isfinite(of_others) ? of_others : of_chosen;
}

}  // namespace curvd
