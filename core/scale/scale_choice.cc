#include "core/scale/scale_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/scale/judging/judged_candidates.h"

namespace curvd {
namespace {

constexpr size_t kMostForCurvatures = 4;

// How many times the error of all candidates' average the average of some errs, who have this part of the weight at a
// point.
double ErrorBesideAll(double weight) {
  constexpr double kLeast = 1e-12;
  return 1.0 / std::sqrt(std::sqrt(std::max(weight, kLeast)));
}

// Which candidate adds the most to some of them.
struct Addition {
  size_t place;          // among the candidates
  double error_without;  // of the average of those before, over that of all candidates' average: a mean over the points
  double error;          // with the addition
};

// Of the candidates from `first` on, that which adds the most to a quantity's estimate by those before it, over all
// sampled points. REQUIRES: first < candidates.size().
Addition BestAddition(const Judged& judged, const std::vector<size_t>& candidates, size_t first) {
  std::vector<double> sums(judged.weights.front().size());
  for (size_t c = 0; c < first; ++c) {
    for (size_t i = 0; i < sums.size(); ++i) sums[i] += judged.weights[candidates[c]][i];
  }
  const auto mean_error = [&](const auto& weight_at) {
    double error = 0.0;
    for (size_t i = 0; i < sums.size(); ++i) error += ErrorBesideAll(weight_at(i));
    return error / static_cast<double>(sums.size());
  };
  Addition best{first, mean_error([&](size_t i) { return sums[i]; }), std::numeric_limits<double>::infinity()};
  for (size_t c = first; c < candidates.size(); ++c) {
    const std::vector<double>& weights = judged.weights[candidates[c]];
    const double error = mean_error([&](size_t i) { return sums[i] + weights[i]; });
    if (error < best.error) best = {c, best.error_without, error};
  }
  return best;
}

// For the curvatures at most kMostForCurvatures candidates, those with the largest shares. The last one is that which
// adds the most to the others: where a part of the cloud is noisier, or sparser, these may all suit the rest of it. One
// more follows where it spares the traceless part a good part of its error.
std::vector<size_t> ChooseTogether(const OfQuantities<Judged>& of) {
  constexpr double kWorthOneMore = 1.05;
  static_assert(ScaleChoice::kMostChosen == kMostForCurvatures + 1);
  std::vector<size_t> order(of.mean.scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto share = [&](size_t s) { return of.mean.shares[s] + of.gaussian.shares[s]; };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return share(a) > share(b); });
  if (order.size() <= kMostForCurvatures) return order;
  constexpr size_t kLast = kMostForCurvatures - 1;
  std::swap(order[kLast], order[BestAddition(of.mean, order, kLast).place]);
  const Addition of_traceless = BestAddition(of.traceless, order, kMostForCurvatures);
  std::swap(order[kMostForCurvatures], order[of_traceless.place]);
  const bool is_worth_it = of_traceless.error_without > kWorthOneMore * of_traceless.error;
  const size_t kept = kMostForCurvatures + (is_worth_it ? 1 : 0);
  order.erase(order.begin() + static_cast<std::ptrdiff_t>(kept), order.end());
  return order;
}

// The traceless part has weights of its own where those of the mean curvature make it err by more than so many times
// as much. Elsewhere the errors of both had better cancel out where they do, as on a ridge, whose k1 is 0.
constexpr double kWorthOwnWeights = 1.1;

// How many times as much the traceless part errs with the weights of the mean curvature, as with its own, by what is
// expected of the chosen candidates: the geometric mean over the sampled points.
double GainOfOwnWeights(const OfQuantities<Judged>& of, const std::vector<size_t>& chosen) {
  const size_t points = of.mean.weights.front().size();
  double logarithms = 0.0;
  for (size_t i = 0; i < points; ++i) {
    const auto error_with = [&](const Judged& weighted, size_t count) {
      double sum = 0.0, total = 0.0;
      for (size_t c = 0; c < count; ++c) {
        sum += weighted.weights[chosen[c]][i] * of.traceless.errors[chosen[c]][i];
        total += weighted.weights[chosen[c]][i];
      }
      return total > 0.0 ? sum / total : 1.0;
    };
    logarithms += std::log(error_with(of.mean, std::min(chosen.size(), kMostForCurvatures)) /
                           error_with(of.traceless, chosen.size()));
  }
  return std::exp(logarithms / static_cast<double>(points));
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

}  // namespace

double AddedError(double error, double other) { return std::sqrt(error * error + other * other); }

double ScaleWeight(double error) { return 1.0 / (error * error * error * error); }

double LocalTrend::ErrorAt(double difference) const {
  return cloud_error * std::pow(difference / cloud_difference, reliance);
}

std::optional<CandidatesThatCount> FindCandidatesThatCount(PilotPoints table, const ScaleBounds& bounds,
                                                           double least_weight) {
  if (table.empty()) return std::nullopt;
  const AllJudged judged = JudgeAll(table, bounds, kWorthwhileToFew);
  std::optional<CandidatesThatCount> found;
  for (const Judged* of : {&judged.of.mean, &judged.of.traceless, &judged.of.gaussian}) {
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

ScaleChoice ChooseScales(PilotPoints table, const ScaleBounds& bounds) {
  ScaleChoice choice;
  if (table.empty()) return choice;
  const AllJudged judged = JudgeAll(table, bounds, kWorthwhile);
  choice.sigma = judged.sigma;
  choice.scores = judged.scores;
  if (choice.scores.empty()) return choice;
  std::vector<size_t> order = ChooseTogether(judged.of);
  if (order.empty()) return choice;
  const bool has_own_weights = GainOfOwnWeights(judged.of, order) > kWorthOwnWeights;
  if (!has_own_weights) order.resize(std::min(order.size(), kMostForCurvatures));
  const auto weights_of = [&](const Judged& of) { return WeightsOf(of, order, bounds.per_cloud); };
  choice.weights = {weights_of(judged.of.mean), {}, weights_of(judged.of.gaussian)};
  if (has_own_weights) {
    choice.weights.traceless = weights_of(judged.of.traceless);
  } else {
    choice.weights.traceless.cloud_weights = choice.weights.mean.cloud_weights;
  }
  for (size_t c = 0; c < order.size(); ++c) {
    choice.chosen.push_back(judged.of.mean.scores[order[c]].candidate);
    const auto is_it = [&](const ScaleScore& score) { return score.candidate == choice.chosen.back(); };
    std::find_if(choice.scores.begin(), choice.scores.end(), is_it)->share = choice.weights.mean.cloud_weights[c];
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
