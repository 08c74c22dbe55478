#include "core/scale/judging/judged_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "core/scale/judging/scale_judge.h"
#include "core/scale/nearest_samples.h"

namespace curvd {
namespace {

// Of each sampled point, the places of those that lie nearest to it.
using Neighbors = std::vector<std::vector<uint32_t>>;

Neighbors NearestOfEach(PilotPoints table) {
  Neighbors nearest;
  nearest.reserve(table.size());
  NearestSamples samples(table);
  for (const PilotPoint& point : table) {
    const std::span<const uint32_t> places = samples.OfAll(point.position.data(), ScaleChoice::kNearest);
    nearest.emplace_back(places.begin(), places.end());
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

// How far the trend of a candidate can be relied on: that of the first scale from it on whose neighborhoods have
// halves.
double Reliance(const CandidateDifferences& of, ScaleCandidate candidate, double floor, const Neighbors& nearest) {
  std::vector<double> means[2];
  for (; candidate.rung < kRungCount; ++candidate.rung) {
    if (!of.HasHalves(candidate)) continue;
    for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd}) {
      std::vector<double> differences = of.AtPoints(candidate, part);
      for (double& difference : differences) difference = std::max(difference, floor);
      means[part - PilotPoint::kEven] = MeansOfNearest(differences, nearest);
    }
    return RelianceOn(means[0], means[1]);
  }
  return 1.0;
}

// The errors of `added`, of the same candidates, are added to those that weights are made of, unless it is null.
Judged JudgeAt(const CandidateDifferences& of, std::vector<ScaleScore> scores, const Neighbors& nearest, bool per_cloud,
               const Judged* added) {
  Judged judged;
  for (const ScaleScore& score : scores) {
    const double floor = of.Floor(score.candidate.rung);
    std::vector<double> differences = of.AtPoints(score.candidate);
    for (double& difference : differences) difference = std::max(difference, floor);
    const double difference = std::max(of.OfCloudWhereCompared(score.candidate), floor);
    const size_t s = judged.trends.size();
    judged.trends.push_back({score.error, difference, per_cloud ? 0.0 : Reliance(of, score.candidate, floor, nearest)});
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

// Jets of degree 6 cost the most: they are dropped unless they are expected to err less than all others times this.
void DropUnlessWorthwhile(double worthwhile, std::vector<ScaleScore>& scores) {
  double least = std::numeric_limits<double>::infinity(), least_of_sextic = least;
  for (const ScaleScore& score : scores) {
    double& of_kind = score.candidate.method == kSexticMethod ? least_of_sextic : least;
    of_kind = std::min(of_kind, score.error);
  }
  if (least_of_sextic <= worthwhile * least) return;
  std::erase_if(scores, [](const ScaleScore& score) { return score.candidate.method == kSexticMethod; });
}

// No difference tells less than rounding makes.
void RaiseToFloor(const CandidateDifferences& of, std::vector<ScaleScore>& scores) {
  for (ScaleScore& score : scores) {
    const double floor = of.Floor(score.candidate.rung);
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

}  // namespace

AllJudged JudgeAll(PilotPoints table, const ScaleBounds& bounds, double worthwhile) {
  using Quantity = ScaleJudge::Quantity;
  const LostDetail lost_detail(table);
  const ScaleJudge of_mean(table, bounds, lost_detail, Quantity::kMean),
      of_traceless(table, bounds, lost_detail, Quantity::kTraceless),
      of_gaussian(table, bounds, lost_detail, Quantity::kGaussian);
  std::vector<ScaleScore> mean = of_mean.Scores(), traceless = of_traceless.Scores();
  DropUnlessWorthwhile(worthwhile, mean);
  AllJudged judged;
  judged.sigma = of_mean.sigma();
  if (mean.empty()) return judged;
  // All have the same candidates, at the same places.
  KeepCandidatesOf(mean, traceless);
  std::vector<ScaleScore> gaussian = of_gaussian.ScoresOf(mean, of_mean);
  std::vector<bool> may_count(mean.size());
  for (const auto& [judge, scores] :
       {std::pair{&of_mean, &mean}, {&of_traceless, &traceless}, {&of_gaussian, &gaussian}}) {
    RaiseToFloor(judge->differences(), *scores);
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
    return JudgeAt(of_quantity.differences(), std::move(kept), nearest, bounds.per_cloud, added);
  };
  judged.of.mean = judge(of_mean, mean);
  judged.of.traceless = judge(of_traceless, traceless, &judged.of.mean);
  judged.of.gaussian = judge(of_gaussian, gaussian);
  return judged;
}

// For each quantity, its differences, and of each candidate that at a point, the expected error and a weight; for all
// of them what is lost and the nearest points.
size_t JudgingBytesPerSample() {
  constexpr size_t kOfCandidate = 3 * sizeof(double);
  using Quantity = ScaleJudge::Quantity;
  size_t bytes = LostDetail::kBytesPerSample;
  for (const Quantity quantity : {Quantity::kMean, Quantity::kTraceless, Quantity::kGaussian}) {
    bytes += CandidateDifferences::BytesPerSample(quantity) + kMethodCount * kRungCount * kOfCandidate;
  }
  return bytes + ScaleChoice::kNearest * sizeof(uint32_t) + sizeof(Neighbors::value_type);
}

}  // namespace curvd
