#include "core/scale/scale_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/scale/judging/scale_judge.h"

namespace curvd {
namespace {

// Of each sampled point, the places of those that lie nearest to it.
using Neighbors = std::vector<std::vector<uint32_t>>;

Neighbors NearestOfEach(PilotPoints table) {
  Neighbors nearest(table.size());
  std::vector<uint32_t> order(table.size());
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
    std::iota(order.begin(), order.end(), 0u);
    std::nth_element(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count - 1), order.end(),
        [&](uint32_t a, uint32_t b) { return squared[a] != squared[b] ? squared[a] < squared[b] : a < b; });
    nearest[i].assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
    std::sort(nearest[i].begin(), nearest[i].end());
  }
  return nearest;
}

// The mean of the values of those that lie nearest to each.
std::vector<double> MeansOfNearest(const std::vector<double>& values, const Neighbors& nearest) {
  std::vector<double> means;
  for (const std::vector<uint32_t>& near : nearest) {
    double sum = 0.0;
    for (const uint32_t i : near) sum += values[i];
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

// What one quantity says of every candidate that may count.
struct Judged {
  std::vector<ScaleScore> scores;
  std::vector<std::vector<double>> differences;  // of each candidate, at each sampled point
  std::vector<LocalTrend> trends;                // of each candidate
  std::vector<std::vector<double>> errors;       // of each candidate, at each sampled point: what weights are made of
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

// The errors of `added`, of the same candidates, are added to those that weights are made of, unless it is null.
Judged JudgeAt(const ScaleJudge& judge, std::vector<ScaleScore> scores, const Neighbors& nearest, bool per_cloud,
               const Judged* added) {
  Judged judged;
  for (const ScaleScore& score : scores) {
    const double floor = judge.Floor(score.candidate.rung);
    std::vector<double> differences = judge.DifferencesAtPoints(score);
    for (double& difference : differences) difference = std::max(difference, floor);
    const double difference = std::max(judge.CloudDifference(score), floor);
    const size_t s = judged.trends.size();
    judged.trends.push_back({score.error, difference, per_cloud ? 0.0 : Reliance(judge, score, floor, nearest)});
    std::vector<double> errors = MeansOfNearest(differences, nearest);
    for (size_t i = 0; i < errors.size(); ++i) {
      errors[i] = judged.trends.back().ErrorAt(errors[i]);
      if (added != nullptr) errors[i] = AddedError(errors[i], added->errors[s][i]);
    }
    judged.errors.push_back(std::move(errors));
    judged.differences.push_back(std::move(differences));
  }
  judged.shares.resize(scores.size());
  judged.weights.assign(scores.size(), std::vector<double>(nearest.size()));
  for (size_t i = 0; i < nearest.size(); ++i) {
    double total = 0.0;
    for (size_t s = 0; s < scores.size(); ++s) {
      judged.weights[s][i] = ScaleWeight(judged.errors[s][i]);
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
  order.resize(kMostForCurvatures + (is_worth_it ? 1 : 0));
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

void DropUnlessWorthwhile(double worthwhile, std::vector<ScaleScore>& scores) {
  double least = std::numeric_limits<double>::infinity(), least_of_sextic = least;
  for (const ScaleScore& score : scores) {
    double& of_kind = score.candidate.method == kSexticMethod ? least_of_sextic : least;
    of_kind = std::min(of_kind, score.error);
  }
  if (least_of_sextic <= worthwhile * least) return;
  std::erase_if(scores, [](const ScaleScore& score) { return score.candidate.method == kSexticMethod; });
}

// What all quantities say, of the same candidates in one order.
struct AllJudged {
  std::vector<ScaleScore> scores;  // of the mean curvature, of all candidates; empty: none can be judged
  OfQuantities<Judged> of;         // of those that may count
  double sigma;                    // noise of the positions
};

// No difference tells less than rounding makes.
void RaiseToFloor(const ScaleJudge& judge, std::vector<ScaleScore>& scores) {
  for (ScaleScore& score : scores) {
    const double floor = judge.Floor(score.candidate.rung);
    score.error = std::max(score.error, floor);
    score.difference = std::max(score.difference, floor);
  }
}

// A candidate whose error is so many times the least one has a millionth of its weight: it counts nowhere.
constexpr double kCountsNowhere = 32.0;

// Marks those of the scores that may count.
void MarkThoseThatCount(const std::vector<ScaleScore>& scores, std::vector<bool>& marks) {
  double least = std::numeric_limits<double>::infinity();
  for (const ScaleScore& score : scores) least = std::min(least, score.error);
  for (size_t i = 0; i < scores.size(); ++i) marks[i] = marks[i] || scores[i].error <= kCountsNowhere * least;
}

// Those of the candidates of `like`, in their order. REQUIRES: both are by method, then by rung.
void KeepCandidatesOf(const std::vector<ScaleScore>& like, std::vector<ScaleScore>& scores) {
  auto kept = like.begin();
  std::erase_if(scores, [&](const ScaleScore& score) {
    if (kept == like.end() || !(kept->candidate == score.candidate)) return true;
    ++kept;
    return false;
  });
}

AllJudged JudgeAll(PilotPoints table, const ScaleBounds& bounds, double worthwhile) {
  using Quantity = ScaleJudge::Quantity;
  const ScaleJudge of_mean(table, bounds, Quantity::kMean), of_traceless(table, bounds, Quantity::kTraceless),
      of_gaussian(table, bounds, Quantity::kGaussian);
  std::vector<ScaleScore> mean = of_mean.Scores(), traceless = of_traceless.Scores();
  DropUnlessWorthwhile(worthwhile, mean);
  AllJudged judged;
  judged.sigma = of_mean.sigma();
  if (mean.empty()) return judged;
  KeepCandidatesOf(mean, traceless);
  std::vector<ScaleScore> gaussian = of_gaussian.ScoresOf(mean, of_mean);
  std::vector<bool> may_count(mean.size());
  for (const auto& [judge, scores] :
       {std::pair{&of_mean, &mean}, {&of_traceless, &traceless}, {&of_gaussian, &gaussian}}) {
    RaiseToFloor(*judge, *scores);
    MarkThoseThatCount(*scores, may_count);
  }
  judged.scores = mean;
  const Neighbors nearest = NearestOfEach(table);
  const auto judge = [&](const ScaleJudge& of_quantity, const std::vector<ScaleScore>& scores,
                         const Judged* added = nullptr) {
    std::vector<ScaleScore> kept;
    for (size_t i = 0; i < scores.size(); ++i) {
      if (may_count[i]) kept.push_back(scores[i]);
    }
    return JudgeAt(of_quantity, std::move(kept), nearest, bounds.per_cloud, added);
  };
  judged.of.mean = judge(of_mean, mean);
  judged.of.traceless = judge(of_traceless, traceless, &judged.of.mean);
  judged.of.gaussian = judge(of_gaussian, gaussian);
  return judged;
}

}  // namespace

double PositionNoise(PilotPoints table) { return ScaleJudge::PositionNoise(table); }

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

// For each quantity, what its judge holds, and of each candidate the difference, the expected error and a weight; for
// all of them the nearest points.
size_t ChoosingBytesPerSample() {
  constexpr size_t kOfCandidate = 3 * sizeof(double);
  using Quantity = ScaleJudge::Quantity;
  size_t of_quantities = 0;
  for (const Quantity quantity : {Quantity::kMean, Quantity::kTraceless, Quantity::kGaussian}) {
    of_quantities += ScaleJudge::BytesPerSample(quantity) + kMethodCount * kRungCount * kOfCandidate;
  }
  return of_quantities + ScaleChoice::kNearest * sizeof(uint32_t) + sizeof(Neighbors::value_type);
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
