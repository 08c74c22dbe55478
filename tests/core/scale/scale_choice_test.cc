#include "core/scale/scale_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

// What a method finds at a rung: noise that falls with the count, and a bias that grows with it, around 1.
struct Behavior {
  double noise;  // at the first rung; falls with the count
  double bias;   // at the last one; grows with the count
};

using Behaviors = std::array<Behavior, kMethodCount>;

// Fills in values around `truth` that behave so.
void SetValues(const Behaviors& behaviors, double truth, double noise_factor, uint64_t seed,
               PilotPoint::Estimates& values) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double detail = normal(random);
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const double growth = kScaleRungs[rung] / static_cast<double>(kScaleRungs[0]);
    for (size_t m = 0; m < kMethodCount; ++m) {
      const double noise = noise_factor * behaviors[m].noise / growth;
      const double value = truth + behaviors[m].bias * detail * kScaleRungs[rung] / kScaleRungs.back();
      const double even = normal(random) * noise, odd = normal(random) * noise;
      auto& parts = values[m][rung];
      parts[PilotPoint::kEven] = static_cast<float>(value + std::sqrt(2.0) * even);
      parts[PilotPoint::kOdd] = static_cast<float>(value + std::sqrt(2.0) * odd);
      parts[PilotPoint::kAll] = static_cast<float>(value + (even + odd) / std::sqrt(2.0));
    }
  }
}

// A table of points of a sphere, in a row, whose estimates behave so, for each method: of the mean curvature, and of
// the traceless part. Those from `first_noisy` on may be noisier.
PilotTable MakeTable(const Behaviors& of_mean, const Behaviors& of_traceless, double noise_factor_of_noisy = 1.0,
                     int first_noisy = 200) {
  PilotTable table;
  for (int i = 0; i < 400; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    const double factor = i < first_noisy ? 1.0 : noise_factor_of_noisy;
    const auto seed = static_cast<uint64_t>(i);
    SetValues(of_mean, 1.0, factor, 3 * seed, point.mean);
    SetValues(of_traceless, 0.0, factor, 3 * seed + 1, point.difference);
    SetValues(of_traceless, 0.0, factor, 3 * seed + 2, point.twist);
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const double growth = kScaleRungs[rung] / static_cast<double>(kScaleRungs[0]);
      point.radius[rung] = static_cast<float>(0.01 * std::sqrt(growth));
      point.steepest[rung] = 1.0f;
      point.residual[rung] = 0.0f;
    }
    table.push_back(point);
  }
  return table;
}

PilotTable MakeTable(const Behaviors& behaviors, double noise_factor_of_noisy = 1.0, int first_noisy = 200) {
  return MakeTable(behaviors, behaviors, noise_factor_of_noisy, first_noisy);
}

// What the first methods do; all others are useless.
Behaviors Behaving(const std::vector<Behavior>& first) {
  Behaviors behaviors;
  behaviors.fill({100.0, 100.0});
  std::copy(first.begin(), first.end(), behaviors.begin());
  return behaviors;
}

uint32_t MeanCount(const ScaleChoice& choice) {
  double logs = 0.0;
  for (size_t c = 0; c < choice.chosen.size(); ++c)
    logs += choice.weights.mean.cloud_weights[c] * std::log2(choice.chosen[c].count());
  return static_cast<uint32_t>(std::exp2(logs));
}

TEST(ScaleChoiceTest, MoreNoiseAsksForMoreNeighborsAndMoreDetailForFewer) {
  const auto choose = [](double noise, double bias) { return ChooseScales(MakeTable(Behaving({{noise, bias}})), {}); };
  const uint32_t calm = MeanCount(choose(0.1, 1.0)), noisy = MeanCount(choose(1.0, 1.0));
  const uint32_t detailed = MeanCount(choose(0.1, 10.0));
  EXPECT_GT(noisy, 2 * calm);
  EXPECT_LT(2 * detailed, calm);
}

TEST(ScaleChoiceTest, TheLargestRungThatCountsIsThatOfTheNoisiestPlace) {
  const auto largest = [](double noise_factor_of_noisy, double least_weight) {
    const PilotTable table = MakeTable(Behaving({{0.05, 10.0}}), noise_factor_of_noisy);
    const auto found = FindCandidatesThatCount(table, {}, least_weight);
    return found.has_value() ? found->largest_rung : 0;
  };
  EXPECT_GT(largest(50.0, 0.01), largest(1.0, 0.01) + 1);
  EXPECT_GT(largest(1.0, 1e-6), largest(1.0, 0.1));
  EXPECT_FALSE(FindCandidatesThatCount({}, {}, 0.01).has_value());
}

TEST(ScaleChoiceTest, JetsOfDegreeSixCountUnlessOthersAreMuchBetter) {
  const auto has_sextic = [](double noise_of_sextic) {
    Behaviors behaviors = Behaving({{0.1, 1.0}});
    behaviors[kSexticMethod] = {noise_of_sextic, 10.0 * noise_of_sextic};
    return FindCandidatesThatCount(MakeTable(behaviors), {}, 1e-6)->methods[kSexticMethod];
  };
  EXPECT_TRUE(has_sextic(0.05));
  EXPECT_TRUE(has_sextic(0.15));
  EXPECT_FALSE(has_sextic(0.4));
}

// What the sampled points show counts twice for a method whose bias they may not show.
TEST(ScaleChoiceTest, TheLinearRegressionMustBeTwiceAsGood) {
  const auto share_of_linear = [](double times) {
    Behaviors behaviors = Behaving({{0.1, 1.0}});
    behaviors[kLinearRegressionMethod] = {times * 0.1, times};
    double share = 0.0;
    for (const ScaleScore& score : ChooseScales(MakeTable(behaviors), {}).scores) {
      if (score.candidate.method == kLinearRegressionMethod) share += score.share;
    }
    return share;
  };
  EXPECT_LT(share_of_linear(1.0), 0.1);
  EXPECT_GT(share_of_linear(0.2), 0.9);
}

TEST(ScaleChoiceTest, WhatLooksAllAroundABodyIsNoMeasureForOthers) {
  ScaleChoice choice;
  choice.scores = {{{kHexagramMethod, 4}, 0.5, 0.5, 0.5, 0.0, 0.0},
                   {{kRegressionMethod, 8}, 0.3, 0.3, 0.3, 0.0, 0.0},
                   {{kQuadricMethod, 8}, 0.4, 0.4, 0.4, 0.0, 0.5}};
  EXPECT_DOUBLE_EQ(LeastLocalError(choice), 0.4) << "of what is chosen";
  choice.scores.push_back({{kLinearRegressionMethod, 14}, 0.01, 0.01, 0.01, 0.0, 0.5});
  EXPECT_DOUBLE_EQ(LeastLocalError(choice), 0.3) << "of all others";
  choice.scores.erase(choice.scores.begin(), choice.scores.begin() + 3);
  EXPECT_DOUBLE_EQ(LeastLocalError(choice), 0.01) << "there are none";
}

TEST(ScaleChoiceTest, TakesTheMethodWithTheLeastError) {
  for (size_t best = 0; best < kMethodCount; ++best) {
    Behaviors behaviors;
    behaviors.fill({1.0, 5.0});
    behaviors[best] = {0.1, 0.5};
    const ScaleChoice choice = ChooseScales(MakeTable(behaviors), {});
    double weight = 0.0;
    for (size_t c = 0; c < choice.chosen.size(); ++c) {
      if (choice.chosen[c].method == best) weight += choice.weights.mean.cloud_weights[c];
    }
    EXPECT_GT(weight, 0.95) << best;
  }
}

TEST(ScaleChoiceTest, TheTracelessPartSharesTheWeightsThatSuitItAsWell) {
  for (const bool per_cloud : {false, true}) {
    ScaleBounds bounds;
    bounds.per_cloud = per_cloud;
    const auto [mean, traceless, gaussian] =
        ChooseScales(MakeTable(Behaving({{1.0, 1.0}, {1.0, 1.0}})), bounds).weights;
    EXPECT_EQ(traceless.cloud_weights, mean.cloud_weights);
    EXPECT_TRUE(traceless.trends.empty());
  }
}

double WeightOf(size_t method, const std::vector<ScaleCandidate>& chosen, const ScaleWeights& weights) {
  double weight = 0.0;
  for (size_t c = 0; c < chosen.size(); ++c) {
    if (chosen[c].method == method) weight += weights.cloud_weights[c];
  }
  return weight;
}

// As on a minimal surface, whose mean curvature is 0 however far estimates look.
TEST(ScaleChoiceTest, TheTracelessPartHasTheMethodThatSuitsIt) {
  constexpr size_t kOfMean = kQuadricMethod, kOfTraceless = kRegressionMethod;
  Behaviors mean = Behaving({}), traceless = mean;
  mean[kOfMean] = {0.01, 0.05};
  traceless[kOfMean] = {1.0, 5.0};
  mean[kOfTraceless] = traceless[kOfTraceless] = {0.1, 0.5};
  const PilotTable table = MakeTable(mean, traceless);
  const ScaleChoice choice = ChooseScales(table, {});
  EXPECT_GT(WeightOf(kOfMean, choice.chosen, choice.weights.mean), 0.9);
  EXPECT_GT(WeightOf(kOfTraceless, choice.chosen, choice.weights.traceless), 0.9);
  EXPECT_FALSE(choice.weights.traceless.trends.empty());
  const auto counts = FindCandidatesThatCount(table, {}, 0.1);
  ASSERT_TRUE(counts.has_value());
  EXPECT_TRUE(counts->methods[kOfMean] && counts->methods[kOfTraceless]);
}

TEST(ScaleChoiceTest, KeepsToItsBounds) {
  const PilotTable table = MakeTable(Behaving({{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}}));
  ScaleBounds bounds;
  bounds.methods = {false, true, false, false, false};
  bounds.least_count = 40;
  bounds.most_count = 100;
  bounds.most_radius = table.front().radius[4];  // 64 neighbors
  const ScaleChoice choice = ChooseScales(table, bounds);
  ASSERT_FALSE(choice.chosen.empty());
  for (const ScaleCandidate& candidate : choice.chosen) {
    EXPECT_EQ(candidate.method, kRegressionMethod);
    EXPECT_TRUE(candidate.count() == 45 || candidate.count() == 64) << candidate.count();
  }
}

TEST(ScaleChoiceTest, WeightsFollowTheNoiseFromPlaceToPlace) {
  const PilotTable table = MakeTable(Behaving({{0.03, 2.0}}), 30.0);
  const ScaleChoice choice = ChooseScales(table, {});
  ASSERT_EQ(choice.weights.mean.local_differences.size(), table.size());
  const auto mean_count = [&](size_t first, size_t last) {
    double logs = 0.0, weights = 0.0;
    for (size_t c = 0; c < choice.chosen.size(); ++c) {
      double difference = 0.0;
      for (size_t i = first; i < last; ++i) {
        difference += choice.weights.mean.local_differences[i][c] / static_cast<double>(last - first);
      }
      const double error = choice.weights.mean.trends[c].ErrorAt(difference);
      logs += ScaleWeight(error) * std::log2(choice.chosen[c].count());
      weights += ScaleWeight(error);
    }
    return std::exp2(logs / weights);
  };
  EXPECT_GT(mean_count(200, 400), 1.5 * mean_count(0, 200));
}

// Many candidates suit the calm part, each about as well: all of those with the largest weights may do so.
TEST(ScaleChoiceTest, EachPartOfACloudHasACandidateThatSuitsIt) {
  constexpr double kNoiseFactor = 30.0;
  const auto behaviors = Behaving({{0.1, 2.0}, {0.1, 2.0}, {0.1, 2.0}});
  const uint32_t noisy = MeanCount(ChooseScales(MakeTable(behaviors, kNoiseFactor, 0), {}));
  const ScaleChoice choice = ChooseScales(MakeTable(behaviors, kNoiseFactor, 320), {});
  uint32_t most = 0;
  for (const ScaleCandidate& candidate : choice.chosen) most = std::max(most, candidate.count());
  EXPECT_GT(2.0 * most, noisy);
}

TEST(ScaleChoiceTest, SharesOfTheChosenSumToOne) {
  for (const bool per_cloud : {false, true}) {
    ScaleBounds bounds;
    bounds.per_cloud = per_cloud;
    const ScaleChoice choice = ChooseScales(MakeTable(Behaving({{1.0, 1.0}})), bounds);
    EXPECT_EQ(choice.chosen.size(), 4u);
    const std::vector<double>& weights = choice.weights.mean.cloud_weights;
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0, 1e-12);
    const auto share = [&](size_t c) { return weights[c] + choice.weights.gaussian.cloud_weights[c]; };
    EXPECT_GE(share(0), share(1));
    EXPECT_GE(share(1), share(2));
    double shares = 0.0;
    for (const ScaleScore& score : choice.scores) shares += score.share;
    EXPECT_NEAR(shares, 1.0, 1e-12);
    EXPECT_EQ(choice.weights.mean.trends.empty(), per_cloud);
    EXPECT_EQ(choice.weights.gaussian.trends.empty(), per_cloud);
  }
}

// As in clouds whose points lie together as near as floats can tell apart.
TEST(ScaleChoiceTest, WhatOverflowsInOneComponentIsJudgedInNone) {
  PilotTable table = MakeTable(Behaving({{1.0, 1.0}, {0.1, 0.1}}));
  for (size_t i = 0; i < table.size(); i += 2) {
    for (auto& parts : table[i].difference[kRegressionMethod]) parts.fill(std::numeric_limits<float>::infinity());
  }
  const ScaleChoice choice = ChooseScales(table, {});
  ASSERT_FALSE(choice.chosen.empty());
  for (const ScaleScore& score : choice.scores) EXPECT_NE(score.candidate.method, kRegressionMethod);
}

// On a plane, and on a sphere that is sampled exactly, every estimate agrees to the last bit.
TEST(ScaleChoiceTest, EstimatesThatAgreeExactlyHaveFiniteWeights) {
  const PilotTable table = MakeTable({Behavior{0.0, 0.0}, Behavior{0.0, 0.0}, Behavior{0.0, 0.0}});
  const ScaleChoice choice = ChooseScales(table, {});
  ASSERT_FALSE(choice.chosen.empty());
  for (const double weight : choice.weights.mean.cloud_weights) EXPECT_TRUE(std::isfinite(weight)) << weight;
  for (const ScaleScore& score : choice.scores) EXPECT_TRUE(std::isfinite(score.error) && score.error > 0.0);
}

TEST(ScaleChoiceTest, ChoosesNothingWhereNothingWasEstimated) {
  EXPECT_TRUE(ChooseScales({}, {}).chosen.empty());
  const PilotTable nothing(100, PilotPoint({0.0f, 0.0f, 0.0f}));
  EXPECT_TRUE(ChooseScales(nothing, {}).chosen.empty());
}

TEST(ScaleChoiceTest, LeavesOutWhatFailsAtManyPoints) {
  PilotTable table = MakeTable(Behaving({{1.0, 1.0}, {0.01, 0.01}}));
  for (size_t i = 0; i < table.size(); i += 20) {
    for (auto& parts : table[i].mean[kRegressionMethod]) parts.fill(PilotPoint::kNone);
  }
  for (const ScaleCandidate& candidate : ChooseScales(table, {}).chosen) EXPECT_NE(candidate.method, kRegressionMethod);
}

}  // namespace
}  // namespace curvd::testing
