#include "core/scale/judging/scale_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

// Where no waves are lost.
ScaleJudge JudgeOf(const PilotTable& table, ScaleJudge::Quantity quantity = ScaleJudge::Quantity::kMean) {
  static const LostDetail kNothing;
  return ScaleJudge(table, ScaleBounds{}, kNothing, quantity);
}

// Points at which hexagrams of 64 and more neighbors err by `bias`, in one direction or the other, with little noise,
// and the cubic regression by noise alone. Nothing else has an estimate.
PilotTable BiasedHexagrams(double bias) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  PilotTable table;
  for (int i = 0; i < 400; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.residual.fill(0.0f);
    point.steepest.fill(1.0f);
    const double lost = bias * normal(random);
    const auto fill = [&](size_t method, size_t rung, double shift, double noise) {
      for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd, PilotPoint::kAll}) {
        point.mean[method][rung][part] = static_cast<float>(1.0 + shift + noise * normal(random));
        point.difference[method][rung][part] = point.twist[method][rung][part] = 0.0f;
      }
    };
    for (size_t rung = 4; rung < kRungCount; ++rung) {
      fill(kHexagramMethod, rung, lost, 0.001);
      fill(kRegressionMethod, rung, 0.0, 0.01);
    }
    table.push_back(point);
  }
  return table;
}

double LeastErrorOf(size_t method, const std::vector<ScaleScore>& scores) {
  double least = std::numeric_limits<double>::infinity();
  for (const ScaleScore& score : scores) {
    if (score.candidate.method == method) least = std::min(least, score.error);
  }
  return least;
}

TEST(ScaleJudgeTest, WhatAllScalesOfAMethodSmoothAwayShowsBesideTheCubicRegression) {
  for (const double bias : {0.05, 0.2}) {
    const PilotTable table = BiasedHexagrams(bias);
    const ScaleJudge judge = JudgeOf(table);
    const std::vector<ScaleScore> scores = judge.Scores();
    EXPECT_NEAR(LeastErrorOf(kHexagramMethod, scores), bias, 0.25 * bias) << "all scales agree with each other";
    EXPECT_NEAR(LeastErrorOf(kRegressionMethod, scores), 0.01, 0.005);

    // Of the Gaussian curvature, which is the square here, the bias is twice as large.
    const ScaleJudge of_gaussian = JudgeOf(table, ScaleJudge::Quantity::kGaussian);
    EXPECT_NEAR(LeastErrorOf(kHexagramMethod, of_gaussian.ScoresOf(scores, judge)), 2.0 * bias, 0.5 * bias);

    // So it is where the mean curvature has ruled the hexagrams out before it looked for their bias.
    std::vector<ScaleScore> ruled_out = scores;
    for (ScaleScore& score : ruled_out) {
      if (score.candidate.method != kHexagramMethod) continue;
      score.bias = 0.0;
      score.is_bias_known = false;
    }
    EXPECT_NEAR(LeastErrorOf(kHexagramMethod, of_gaussian.ScoresOf(ruled_out, judge)), 2.0 * bias, 0.5 * bias);
  }
}

// Points whose normals err by `bias`, in one direction or the other, together with those of their neighbors:
// regressions of both halves, and of all scales, agree. Jets of degree 4 err by noise alone. `residual` is what they
// leave of heights.
PilotTable BiasedNormals(double bias, float residual) {
  PilotTable table = BiasedHexagrams(0.0);
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (PilotPoint& point : table) {
    point.residual.fill(residual);
    const double shared = bias * normal(random);
    for (size_t rung = 4; rung < kRungCount; ++rung) {
      for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd, PilotPoint::kAll}) {
        point.mean[kRegressionMethod][rung][part] += static_cast<float>(shared);
        point.mean[kQuarticMethod][rung][part] = static_cast<float>(1.0 + 0.01 * normal(random));
        point.difference[kQuarticMethod][rung][part] = point.twist[kQuarticMethod][rung][part] = 0.0f;
      }
    }
  }
  return table;
}

TEST(ScaleJudgeTest, WhatNormalsShareWithTheirNeighborsShowsBesideExactPositions) {
  const PilotTable exact = BiasedNormals(0.2, 0.0f), agreeing = BiasedNormals(0.01, 0.0f),
                   noisy = BiasedNormals(0.2, 0.002f);
  const ScaleJudge judge = JudgeOf(exact);
  const std::vector<ScaleScore> scores = judge.Scores();
  EXPECT_NEAR(LeastErrorOf(kRegressionMethod, scores), 0.2, 0.05);
  EXPECT_NEAR(LeastErrorOf(kQuarticMethod, scores), 0.01, 0.005);
  const ScaleJudge of_gaussian = JudgeOf(exact, ScaleJudge::Quantity::kGaussian);
  EXPECT_NEAR(LeastErrorOf(kRegressionMethod, of_gaussian.ScoresOf(scores, judge)), 0.4, 0.1);
  for (const PilotTable* const table : {&agreeing, &noisy}) {
    const ScaleJudge other = JudgeOf(*table);
    EXPECT_NEAR(LeastErrorOf(kRegressionMethod, other.Scores()), 0.01, 0.005);
  }
}

TEST(ScaleJudgeTest, TheTracelessPartIsJudgedAsAVectorWhateverThePointsFrames) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * 3.14159265);
  for (const double bias : {0.05, 0.2}) {
    // What hexagrams lose and what noise adds is along the x axis of each frame, that is, turned by another angle.
    PilotTable table = BiasedHexagrams(bias), turned = table;
    for (size_t i = 0; i < table.size(); ++i) {
      const double at = angle(random);
      for (size_t method : {kHexagramMethod, kRegressionMethod}) {
        for (size_t rung = 4; rung < kRungCount; ++rung) {
          for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd, PilotPoint::kAll}) {
            const float value = table[i].mean[method][rung][part];
            table[i].difference[method][rung][part] = value;
            turned[i].difference[method][rung][part] = static_cast<float>(std::cos(at)) * value;
            turned[i].twist[method][rung][part] = static_cast<float>(std::sin(at)) * value;
            table[i].mean[method][rung][part] = turned[i].mean[method][rung][part] = 0.0f;
          }
        }
      }
    }
    constexpr auto kTraceless = ScaleJudge::Quantity::kTraceless;
    const std::vector<ScaleScore> scores = JudgeOf(table, kTraceless).Scores();
    const std::vector<ScaleScore> of_turned = JudgeOf(turned, kTraceless).Scores();
    EXPECT_NEAR(LeastErrorOf(kHexagramMethod, scores), bias, 0.25 * bias);
    EXPECT_NEAR(LeastErrorOf(kRegressionMethod, scores), 0.01, 0.005);
    ASSERT_EQ(of_turned.size(), scores.size());
    for (size_t i = 0; i < scores.size(); ++i) {
      EXPECT_EQ(of_turned[i].candidate, scores[i].candidate);
      EXPECT_NEAR(of_turned[i].error / scores[i].error, 1.0, 1e-3);
    }
  }
}

// Regressions of 64 and more neighbors that agree, but for noise of 64 neighbors, of which this share is common to both
// halves.
PilotTable RegressionsWithCommonNoise(int points, double share) {
  PilotTable table;
  for (int i = 0; i < points; ++i) {
    PilotPoint& point = table.emplace_back(std::array<float, 3>{static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.residual.fill(0.0f);
    point.steepest.fill(1.0f);
    for (size_t rung = 4; rung < kRungCount; ++rung) {
      const double noise = rung == 4 ? 1000.0 : 0.001;
      // Halves agree in sign more often than not.
      const bool do_agree = i < 0.5 * points * (1.0 + share);
      const double even = i % 2 == 0 ? noise : -noise, odd = do_agree ? even : -even;
      point.mean[kRegressionMethod][rung] = {static_cast<float>(0.5 * (even + odd)), static_cast<float>(even),
                                             static_cast<float>(odd)};
      for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd, PilotPoint::kAll}) {
        point.difference[kRegressionMethod][rung][part] = point.twist[kRegressionMethod][rung][part] = 0.0f;
      }
    }
  }
  return table;
}

TEST(ScaleJudgeTest, NoiseOfSmallNeighborhoodsIsNoBiasOfLargeOnes) {
  const auto least_error = [](int points, double share) {
    const PilotTable table = RegressionsWithCommonNoise(points, share);
    return LeastErrorOf(kRegressionMethod, JudgeOf(table).Scores());
  };
  // A standard error is 0.1.
  EXPECT_LT(least_error(400, 0.23), 0.01);
  EXPECT_GT(least_error(400, 0.28), 100.0);
  // A standard error is 0.22.
  EXPECT_LT(least_error(60, 0.4), 0.01);
  EXPECT_GT(least_error(60, 0.7), 100.0);
}

TEST(ScaleJudgeTest, WavesThatNeighborhoodsLoseAreTheirBias) {
  PilotTable table = BiasedHexagrams(0.0);
  // Waves with a height of 0.1, which jets lose at the radius of 128 neighbors.
  for (size_t i = 0; i < table.size(); ++i) {
    const float chance = i % 2 == 0 ? 0.99f : 1.01f;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      table[i].radius[rung] = std::sqrt(static_cast<float>(kScaleRungs[rung]));
      table[i].residual[rung] = chance * (rung < 6 ? 0.05f : 0.1f);
    }
  }
  const LostDetail waves(table);
  const std::vector<ScaleScore> scores = ScaleJudge(table, ScaleBounds{}, waves, ScaleJudge::Quantity::kMean).Scores();
  size_t found = 0;
  for (const ScaleScore& score : scores) {
    if (!score.is_bias_known) continue;
    const double lost = std::sqrt(waves.SquaredBias(score.candidate));
    EXPECT_GE(score.bias, lost) << score.candidate.method << ", " << score.candidate.rung;
    found += lost > 0.0 ? 1 : 0;
  }
  EXPECT_GT(found, 0u);
}

TEST(ScaleJudgeTest, WhereChangesDoNotGrowTheBiasIsMoreThanSmallerNeighborhoodsShow) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  // Cubic regressions lose as much from each rung of 64 neighbors on, and have lost as much before.
  PilotTable table = BiasedHexagrams(0.0);
  for (PilotPoint& point : table) {
    const double lost = 0.1 * normal(random);
    for (size_t rung = 4; rung < kRungCount; ++rung) {
      const double steps = static_cast<double>(rung) - 2.0;
      for (float& part : point.mean[kRegressionMethod][rung]) part += static_cast<float>(steps * lost);
    }
  }
  for (const ScaleScore& score : JudgeOf(table).Scores()) {
    if (score.candidate.method != kRegressionMethod || !score.is_bias_known) continue;
    const double true_bias = 0.1 * (static_cast<double>(score.candidate.rung) - 2.0);
    EXPECT_NEAR(score.bias / true_bias, 0.8, 0.2) << score.candidate.rung;
    EXPECT_NEAR(score.bias_per_change, true_bias / 0.1, 0.8) << score.candidate.rung;
  }
}

// Regressions of 32 and more neighbors, with halves from 45 on, whose noise halves its variance from rung to rung.
// From 45 neighbors on they have lost `lost`, in one direction or the other, and no more.
PilotTable NoisyRegressions(double lost) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  PilotTable table;
  for (int i = 0; i < 400; ++i) {
    PilotPoint& point = table.emplace_back(std::array<float, 3>{static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.residual.fill(0.0f);
    point.steepest.fill(1.0f);
    const double of_point = lost * normal(random);
    for (size_t rung = 2; rung < kRungCount; ++rung) {
      const double steps = static_cast<double>(rung) - 2.0, deviation = std::exp2(-0.5 * steps);
      const double even = 1.0 + steps * of_point + deviation * normal(random);
      const double odd = 1.0 + steps * of_point + deviation * normal(random);
      auto& means = point.mean[kRegressionMethod][rung];
      means = {static_cast<float>(0.5 * (even + odd)), static_cast<float>(even), static_cast<float>(odd)};
      if (rung == 2) means[PilotPoint::kEven] = means[PilotPoint::kOdd] = std::nanf("");
      point.difference[kRegressionMethod][rung].fill(0.0f);
      point.twist[kRegressionMethod][rung].fill(0.0f);
    }
  }
  return table;
}

TEST(ScaleJudgeTest, NeighborhoodsWithoutHalvesHaveTheNoiseThatThoseWithHalvesTellUnlessTheseHaveLostDetail) {
  const auto noise_of_first = [](double lost) {
    const PilotTable table = NoisyRegressions(lost);
    for (const ScaleScore& score : JudgeOf(table).Scores()) {
      if (score.candidate == ScaleCandidate{kRegressionMethod, 2}) return score.noise;
    }
    return -1.0;
  };
  // Half of the variance of a half, which is 1.
  EXPECT_NEAR(noise_of_first(0.0), std::sqrt(0.5), 0.15);
  EXPECT_EQ(noise_of_first(1.0), 0.0);
}

TEST(ScaleJudgeTest, AFewPointsThatAreFarOffCountInTheError) {
  PilotTable table = BiasedHexagrams(0.0);
  const auto least_error = [&] {
    const ScaleJudge judge = JudgeOf(table);
    return LeastErrorOf(kRegressionMethod, judge.Scores());
  };
  const double before = least_error();
  // At one point in 25 the scales disagree by 1: that alone comes to a mean difference of 0.04.
  for (size_t i = 0; i < table.size(); i += 25) {
    for (size_t rung = 4; rung < kRungCount; ++rung) {
      for (float& part : table[i].mean[kRegressionMethod][rung]) part += rung % 2 == 0 ? 1.0f : 0.0f;
    }
  }
  EXPECT_LT(before, 0.015);
  EXPECT_GT(least_error(), 0.03);
}

// What the smallest cubic regression is expected to err by, where from scale to scale it changes by these values at
// every point, and no halves tell of noise.
double ErrorOfFirstRung(const std::vector<float>& changes) {
  PilotTable table;
  for (int i = 0; i < 100; ++i) {
    PilotPoint& point = table.emplace_back(std::array<float, 3>{static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.steepest.fill(1.0f);
    point.residual.fill(0.0f);
    float value = 1.0f;
    for (size_t rung = 0; rung <= changes.size(); ++rung) {
      point.mean[kRegressionMethod][rung][PilotPoint::kAll] = value;
      point.difference[kRegressionMethod][rung][PilotPoint::kAll] = 0.0f;
      point.twist[kRegressionMethod][rung][PilotPoint::kAll] = 0.0f;
      if (rung < changes.size()) value += changes[rung];
    }
  }
  const ScaleJudge judge = JudgeOf(table);
  return judge.Scores().front().error;
}

// A change tells the error of the larger scale where errors grow; where the first two are alike, noise may be what
// changes.
TEST(ScaleJudgeTest, TheFirstErrorIsLessThanItsChangeOnlyAsFarAsChangesGrowThere) {
  EXPECT_LT(ErrorOfFirstRung({0.004f, 0.01f, 0.1f, 1.0f}), 0.003);
  EXPECT_GT(ErrorOfFirstRung({0.0100f, 0.0101f, 0.05f, 1.0f}), 0.0095);
}

}  // namespace
}  // namespace curvd::testing
