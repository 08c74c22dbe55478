#include "core/scale/judging/candidate_differences.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

constexpr auto kMean = CandidateDifferences::Quantity::kMean;
constexpr size_t kSampledPoints = 400;
constexpr ScaleCandidate kSmall = {kRegressionMethod, 4}, kLarge = {kRegressionMethod, 5};

// Points without estimates, whose neighborhoods have a radius of 1.
PilotTable PointsWithoutEstimates() {
  PilotTable table;
  for (size_t i = 0; i < kSampledPoints; ++i) {
    table.emplace_back(std::array<float, 3>{static_cast<float>(i), 0.0f, 0.0f}).radius.fill(1.0f);
  }
  return table;
}

void SetMean(const ScaleCandidate& candidate, double even, double odd, PilotPoint& point) {
  auto& means = point.mean[candidate.method][candidate.rung];
  means[PilotPoint::kEven] = static_cast<float>(even);
  means[PilotPoint::kOdd] = static_cast<float>(odd);
  means[PilotPoint::kAll] = static_cast<float>(0.5 * (even + odd));
  point.difference[candidate.method][candidate.rung].fill(0.0f);
  point.twist[candidate.method][candidate.rung].fill(0.0f);
}

// Regressions of 64 neighbors are right but for noise of 0.1 in each half; those of 91 neighbors have lost `lost` of
// it, in one direction or the other.
PilotTable TwoScales(double lost) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  PilotTable table = PointsWithoutEstimates();
  for (PilotPoint& point : table) {
    const double detail = lost * normal(random);
    SetMean(kSmall, 1.0 + 0.1 * normal(random), 1.0 + 0.1 * normal(random), point);
    SetMean(kLarge, 1.0 + detail, 1.0 + detail, point);
  }
  return table;
}

TEST(CandidateDifferencesTest, HalvesTellTheVarianceOfNoise) {
  const PilotTable table = TwoScales(0.0);
  const CandidateDifferences differences(table, kMean);
  EXPECT_TRUE(differences.HasHalves(kSmall));
  EXPECT_NEAR(differences.Variance(kSmall), 0.5 * 0.1 * 0.1, 0.001);
  EXPECT_FALSE(differences.HasHalves({kRegressionMethod, 6}));
  EXPECT_EQ(differences.Variance({kRegressionMethod, 6}), 0.0);
}

// Regressions of 32 and more neighbors, of which those of 45 and more have halves; their noise has this variance.
template <typename Variance>
PilotTable NoisyFrom45(const Variance& variance_of) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  PilotTable table = PointsWithoutEstimates();
  for (PilotPoint& point : table) {
    for (size_t rung = 2; rung < kRungCount; ++rung) {
      const double of_half = std::sqrt(2.0 * variance_of(rung));
      SetMean({kRegressionMethod, rung}, 1.0 + of_half * normal(random), 1.0 + of_half * normal(random), point);
      if (rung > 2) continue;
      auto& means = point.mean[kRegressionMethod][rung];
      means[PilotPoint::kEven] = means[PilotPoint::kOdd] = std::nanf("");
    }
  }
  return table;
}

TEST(CandidateDifferencesTest, WhereHalvesBeginTheirVarianceTellsThatOfFewerNeighborsIfItFallsAsNoiseDoes) {
  const auto halved = [](size_t rung) { return 0.01 * std::exp2(-static_cast<double>(rung)); };
  const PilotTable noisy = NoisyFrom45(halved), even = NoisyFrom45([](size_t) { return 0.001; });
  const CandidateDifferences of_noisy(noisy, kMean), of_even(even, kMean);
  EXPECT_EQ(of_noisy.FirstWithVariance(kRegressionMethod), 3u);
  EXPECT_EQ(of_noisy.FirstWithVariance(kQuarticMethod), kRungCount);
  EXPECT_NEAR(of_noisy.VarianceBeforeFirst({kRegressionMethod, 2}) / halved(2), 1.0, 0.3);
  EXPECT_EQ(of_noisy.VarianceBeforeFirst({kRegressionMethod, 3}), 0.0) << "it has halves";
  EXPECT_EQ(of_noisy.VarianceBeforeFirst({kQuarticMethod, 2}), 0.0);
  EXPECT_EQ(of_even.VarianceBeforeFirst({kRegressionMethod, 2}), 0.0) << "more neighbors average noise";
}

TEST(CandidateDifferencesTest, WhatHalvesHaveInCommonIsDetailAndNotNoise) {
  for (const double lost : {0.3, 1.0}) {
    const PilotTable table = TwoScales(lost);
    // Products are cut down at their quantiles, and two standard errors are taken off.
    EXPECT_NEAR(CandidateDifferences(table, kMean).CommonSquare(kLarge, kSmall).value_or(0.0), lost * lost,
                0.5 * lost * lost);
    EXPECT_EQ(CandidateDifferences(table, kMean).CommonSquareBesideSmaller(kLarge),
              CandidateDifferences(table, kMean).CommonSquare(kLarge, kSmall).value_or(0.0));
  }
  const PilotTable table = TwoScales(0.0);
  EXPECT_EQ(CandidateDifferences(table, kMean).CommonSquare(kLarge, kSmall), 0.0);
  EXPECT_FALSE(CandidateDifferences(table, kMean).CommonSquare(kLarge, {kRegressionMethod, 6}).has_value());
}

TEST(CandidateDifferencesTest, ADifferenceIsThatFromTheNextScale) {
  PilotTable table = PointsWithoutEstimates();
  for (PilotPoint& point : table) {
    SetMean(kSmall, 1.0, 1.0, point);
    SetMean(kLarge, 1.5, 1.5, point);
  }
  // At one point in 200 it is far more, which is cut down to what others have.
  for (size_t i = 0; i < kSampledPoints; i += 200) SetMean(kLarge, 100.0, 100.0, table[i]);
  const CandidateDifferences differences(table, kMean);
  EXPECT_NEAR(differences.OfCloud(kSmall).value_or(0.0), 1.2 * 0.5, 1e-6);
  for (const double at_point : differences.AtPoints(kSmall)) EXPECT_NEAR(at_point, 0.5, 1e-6);
  // The largest has none to be compared with.
  EXPECT_EQ(differences.OfCloudWhereCompared(kLarge), differences.OfCloud(kSmall).value_or(0.0));
}

TEST(CandidateDifferencesTest, PointsWithoutADifferenceHaveTheUsualOneBesideAnEdgeAndElsewhereTheLargest) {
  PilotTable table = PointsWithoutEstimates();
  for (size_t i = 0; i < kSampledPoints; ++i) {
    SetMean(kSmall, 1.0, 1.0, table[i]);
    SetMean(kLarge, i % 20 == 19 ? 3.0 : 2.0, i % 20 == 19 ? 3.0 : 2.0, table[i]);
  }
  SetMean(kLarge, std::nan(""), std::nan(""), table[0]);
  SetMean(kLarge, std::nan(""), std::nan(""), table[1]);
  table[1].clear_rungs = kLarge.rung;
  const std::vector<double> at_points = CandidateDifferences(table, kMean).AtPoints(kSmall);
  EXPECT_NEAR(at_points[0], 2.0, 1e-6);
  EXPECT_NEAR(at_points[1], 1.2, 1e-6);
  EXPECT_NEAR(at_points[2], 1.0, 1e-6);
}

TEST(CandidateDifferencesTest, ACandidateThatTooFewPointsHaveIsNotCompared) {
  PilotTable table = TwoScales(0.5);
  EXPECT_TRUE(CandidateDifferences(table, kMean).OfCloud(kSmall).has_value());
  for (size_t i = 0; i < kSampledPoints / 20; ++i) SetMean(kLarge, std::nan(""), std::nan(""), table[i]);
  EXPECT_FALSE(CandidateDifferences(table, kMean).OfCloud(kSmall).has_value());
  // Those whose neighborhoods reach over an edge need none.
  for (size_t i = 0; i < kSampledPoints / 20; ++i) table[i].clear_rungs = kLarge.rung;
  EXPECT_TRUE(CandidateDifferences(table, kMean).OfCloud(kSmall).has_value());
}

}  // namespace
}  // namespace curvd::testing
