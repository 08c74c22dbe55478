#include "core/scale/judging/judged_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <random>
#include <utility>
#include <vector>

namespace curvd::testing {
namespace {

constexpr size_t kJudgedPoints = 200;
constexpr float kResidual = 0.001f;  // of positions
constexpr double kAlwaysWorthwhile = 1e9;

// The noise of a method's estimates from its first rung to its last one; those are all. That of the traceless part is
// so many times as large.
struct NoisyMethod {
  size_t method;
  double noise;
  size_t first_rung = 4, last_rung = kRungCount - 1;
  double traceless_noise = 1.0;
};

// Points on a line, at which methods err by nothing but noise; both halves of neighborhoods have estimates.
PilotTable TableOf(const std::vector<NoisyMethod>& methods) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  PilotTable table;
  for (size_t i = 0; i < kJudgedPoints; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.residual.fill(kResidual);
    point.steepest.fill(1.0f);
    for (const NoisyMethod& of : methods) {
      for (size_t rung = of.first_rung; rung <= of.last_rung; ++rung) {
        for (const auto part : {PilotPoint::kEven, PilotPoint::kOdd, PilotPoint::kAll}) {
          point.mean[of.method][rung][part] = static_cast<float>(2.0 + of.noise * normal(random));
          point.difference[of.method][rung][part] =
              static_cast<float>(1.0 + of.noise * of.traceless_noise * normal(random));
          point.twist[of.method][rung][part] = static_cast<float>(of.noise * of.traceless_noise * normal(random));
        }
      }
    }
    table.push_back(point);
  }
  return table;
}

std::vector<ScaleCandidate> CandidatesOf(const std::vector<ScaleScore>& scores) {
  std::vector<ScaleCandidate> candidates;
  candidates.reserve(scores.size());
  for (const ScaleScore& score : scores) candidates.push_back(score.candidate);
  return candidates;
}

bool HaveMethod(const std::vector<ScaleScore>& scores, size_t method) {
  return std::any_of(scores.begin(), scores.end(),
                     [method](const ScaleScore& score) { return score.candidate.method == method; });
}

std::array<const Judged*, 3> AllOf(const AllJudged& judged) {
  return {&judged.of.mean, &judged.of.traceless, &judged.of.gaussian};
}

// Jets of degree 6 that err by so much, beside regressions that err by 0.01.
PilotTable SexticBesideRegression(double noise) {
  return TableOf({{kRegressionMethod, 0.01}, {kSexticMethod, noise, 4, 8}});
}

TEST(JudgedCandidatesTest, SexticJetsAreDroppedUnlessTheyAreWorthwhile) {
  const PilotTable table = SexticBesideRegression(0.005);
  for (const auto& [worthwhile, is_kept] :
       {std::pair{kAlwaysWorthwhile, true}, {0.7, true}, {0.3, false}, {0.0, false}}) {
    const AllJudged judged = JudgeAll(table, ScaleBounds{}, worthwhile);
    EXPECT_TRUE(HaveMethod(judged.scores, kRegressionMethod));
    EXPECT_EQ(HaveMethod(judged.scores, kSexticMethod), is_kept) << worthwhile;
    for (const Judged* const of : AllOf(judged)) {
      EXPECT_TRUE(HaveMethod(of->scores, kRegressionMethod)) << worthwhile;
      EXPECT_EQ(HaveMethod(of->scores, kSexticMethod), is_kept) << worthwhile;
    }
  }
  // Nothing else is dropped for being no better.
  const AllJudged quartic = JudgeAll(TableOf({{kRegressionMethod, 0.01}, {kQuarticMethod, 0.01}}), ScaleBounds{}, 0.3);
  EXPECT_TRUE(HaveMethod(quartic.scores, kQuarticMethod));
}

TEST(JudgedCandidatesTest, SexticJetsAloneAreKept) {
  const AllJudged judged = JudgeAll(TableOf({{kSexticMethod, 0.01, 4, 8}}), ScaleBounds{}, 0.3);
  EXPECT_TRUE(HaveMethod(judged.scores, kSexticMethod)) << "there is nothing that errs less";
}

TEST(JudgedCandidatesTest, AllQuantitiesHaveTheSameCandidatesInOneOrder) {
  const PilotTable table = TableOf(
      {{kHexagramMethod, 0.02}, {kRegressionMethod, 0.01}, {kQuarticMethod, 0.03}, {kSexticMethod, 0.04, 4, 8}});
  for (const double worthwhile : {kAlwaysWorthwhile, 0.5}) {
    const AllJudged judged = JudgeAll(table, ScaleBounds{}, worthwhile);
    const std::vector<ScaleCandidate> candidates = CandidatesOf(judged.of.mean.scores);
    ASSERT_GT(candidates.size(), 10u);
    EXPECT_TRUE(std::is_sorted(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
      return std::pair(a.method, a.rung) < std::pair(b.method, b.rung);
    }));
    for (const Judged* const of : AllOf(judged)) {
      EXPECT_EQ(CandidatesOf(of->scores), candidates);
      EXPECT_EQ(of->differences.size(), candidates.size());
      EXPECT_EQ(of->trends.size(), candidates.size());
      EXPECT_EQ(of->errors.size(), candidates.size());
      EXPECT_EQ(of->weights.size(), candidates.size());
      EXPECT_EQ(of->shares.size(), candidates.size());
    }
  }
}

TEST(JudgedCandidatesTest, WeightsArePartsOfOneAtEachPoint) {
  const AllJudged judged =
      JudgeAll(TableOf({{kHexagramMethod, 0.02}, {kRegressionMethod, 0.01}}), ScaleBounds{}, kAlwaysWorthwhile);
  for (const Judged* const of : AllOf(judged)) {
    std::vector<double> sums(of->scores.size());
    for (size_t i = 0; i < kJudgedPoints; ++i) {
      double total = 0.0;
      for (size_t c = 0; c < of->scores.size(); ++c) {
        const double weight = of->weights[c][i];
        EXPECT_GE(weight, 0.0);
        total += weight;
        sums[c] += weight;
        // A smaller error has a larger weight.
        EXPECT_EQ(weight > of->weights[0][i], of->errors[c][i] < of->errors[0][i]);
      }
      EXPECT_NEAR(total, 1.0, 1e-12);
    }
    for (size_t c = 0; c < of->scores.size(); ++c) EXPECT_NEAR(of->shares[c], sums[c] / kJudgedPoints, 1e-12);
  }
}

// Where an estimate loses H, the rest is seldom right.
TEST(JudgedCandidatesTest, TheTracelessPartIsWeighedByBothErrors) {
  const AllJudged judged =
      JudgeAll(TableOf({{kRegressionMethod, 0.01, 4, kRungCount - 1, 0.1}}), ScaleBounds{}, kAlwaysWorthwhile);
  ASSERT_FALSE(judged.scores.empty());
  for (size_t c = 0; c < judged.of.mean.scores.size(); ++c) {
    EXPECT_LT(judged.of.traceless.scores[c].error, 0.5 * judged.of.mean.scores[c].error);
    for (size_t i = 0; i < kJudgedPoints; ++i) {
      ASSERT_GE(judged.of.traceless.errors[c][i], judged.of.mean.errors[c][i]);
    }
  }
}

TEST(JudgedCandidatesTest, TellsTheNoiseOfPositions) {
  EXPECT_EQ(JudgeAll(TableOf({{kRegressionMethod, 0.01}}), ScaleBounds{}, kAlwaysWorthwhile).sigma, kResidual);
}

// An error that is so many times the least one counts nowhere, but is told.
TEST(JudgedCandidatesTest, FarLargerErrorsDoNotCount) {
  const AllJudged judged =
      JudgeAll(TableOf({{kHexagramMethod, 1.0}, {kRegressionMethod, 0.01}}), ScaleBounds{}, kAlwaysWorthwhile);
  EXPECT_TRUE(HaveMethod(judged.scores, kHexagramMethod));
  EXPECT_TRUE(HaveMethod(judged.scores, kRegressionMethod));
  for (const Judged* const of : AllOf(judged)) {
    EXPECT_FALSE(HaveMethod(of->scores, kHexagramMethod));
    EXPECT_TRUE(HaveMethod(of->scores, kRegressionMethod));
  }
}

// Where estimates are exact, differences tell no less than rounding makes.
TEST(JudgedCandidatesTest, ErrorsOfExactEstimatesAreThoseOfRounding) {
  const AllJudged judged = JudgeAll(TableOf({{kRegressionMethod, 0.0}}), ScaleBounds{}, kAlwaysWorthwhile);
  ASSERT_FALSE(judged.scores.empty());
  for (const Judged* const of : AllOf(judged)) {
    for (size_t c = 0; c < of->scores.size(); ++c) {
      EXPECT_GT(of->scores[c].error, 1e-8);
      EXPECT_LT(of->scores[c].error, 1e-4);
      EXPECT_GT(of->scores[c].difference, 0.0);
      for (const double difference : of->differences[c]) ASSERT_GT(difference, 0.0);
      for (const double weight : of->weights[c]) ASSERT_TRUE(weight > 0.0 && weight <= 1.0);
    }
  }
}

TEST(JudgedCandidatesTest, NoTrendIsReliedOnWhereTheCloudHasTheSameWeightsEverywhere) {
  const PilotTable table = TableOf({{kRegressionMethod, 0.01}});
  const AllJudged judged = JudgeAll(table, ScaleBounds{.per_cloud = true}, kAlwaysWorthwhile);
  ASSERT_FALSE(judged.scores.empty());
  for (const Judged* const of : AllOf(judged)) {
    for (const LocalTrend& trend : of->trends) EXPECT_EQ(trend.reliance, 0.0);
  }
}

// Points of the second half of the line, whose noise is ten times as large.
TEST(JudgedCandidatesTest, ErrorsFollowWhatDiffersFromPlaceToPlace) {
  PilotTable table = TableOf({{kRegressionMethod, 0.01}});
  const PilotTable noisy = TableOf({{kRegressionMethod, 0.1}});
  for (size_t i = kJudgedPoints / 2; i < kJudgedPoints; ++i) table[i] = noisy[i];
  const AllJudged judged = JudgeAll(table, ScaleBounds{}, kAlwaysWorthwhile);
  ASSERT_FALSE(judged.scores.empty());
  for (const LocalTrend& trend : judged.of.mean.trends) EXPECT_GT(trend.reliance, 0.5);
  for (const std::vector<double>& errors : judged.of.mean.errors) EXPECT_GT(errors.back(), 4.0 * errors.front());
}

TEST(JudgedCandidatesTest, TablesWithoutEstimatesAreNotJudged) {
  EXPECT_TRUE(JudgeAll(TableOf({}), ScaleBounds{}, 1.0).scores.empty());
  // Nor are candidates that are not allowed.
  ScaleBounds bounds;
  bounds.methods[kRegressionMethod] = false;
  const AllJudged judged = JudgeAll(TableOf({{kRegressionMethod, 0.01}}), bounds, 1.0);
  EXPECT_TRUE(judged.scores.empty());
  EXPECT_TRUE(judged.of.mean.scores.empty());
}

}  // namespace
}  // namespace curvd::testing
