#include "core/scale/errors/error_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

constexpr size_t kRung = 6;

// What is estimated at each of many sampled points: the shape operator diag(1, 3), of which smoothing takes
// `lost` times the neighbor count over that of kRung, under noise of standard deviation `noise` at that rung.
PilotTable MakeTable(double noise, double lost, size_t halves_from = 0) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  PilotTable table;
  for (int i = 0; i < 400; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const double growth = static_cast<double>(kScaleRungs[rung]) / kScaleRungs[kRung];
      point.radius[rung] = static_cast<float>(0.1 * std::sqrt(growth));
      std::array<double, 3> at[2];
      for (auto& half : at) {
        for (double& component : half) component = std::sqrt(2.0) * noise / growth * normal(random);
        half[0] += 2.0 - lost * growth;
        half[1] -= 1.0;
      }
      const auto set = [&](PilotPoint::Part part, double even, double odd) {
        point.mean[kRegressionMethod][rung][part] = static_cast<float>(even * at[0][0] + odd * at[1][0]);
        point.difference[kRegressionMethod][rung][part] = static_cast<float>(even * at[0][1] + odd * at[1][1]);
        point.twist[kRegressionMethod][rung][part] = static_cast<float>(even * at[0][2] + odd * at[1][2]);
      };
      set(PilotPoint::kAll, 0.5, 0.5);
      if (rung < halves_from) continue;
      set(PilotPoint::kEven, 1.0, 0.0);
      set(PilotPoint::kOdd, 0.0, 1.0);
    }
    table.push_back(point);
  }
  return table;
}

ScaleChoice Choosing(size_t rung, double sigma = 0.0) {
  ScaleChoice choice;
  choice.chosen = {{kRegressionMethod, rung}};
  choice.weights.mean.cloud_weights = choice.weights.traceless.cloud_weights = {1.0};
  choice.scores = {{choice.chosen.front(), 1.0, 1.0, 1.0, 0.0, 1.0}};
  choice.sigma = sigma;
  return choice;
}

constexpr double kOne[] = {1.0};

ErrorSample MeanOf(const std::vector<ErrorSample>& samples) {
  ErrorSample mean;
  const double share = 1.0 / static_cast<double>(samples.size());
  for (const ErrorSample& sample : samples) {
    EXPECT_TRUE(sample.is_known);
    for (size_t part = 0; part < kShapeParts; ++part) {
      mean.noise[part] += share * sample.noise[part];
      mean.detail[part] += share * sample.detail[part];
      mean.place[part] += share * sample.place[part];
    }
    mean.lean += share * sample.lean;
  }
  return mean;
}

TEST(ErrorSamplesTest, TheHalvesTellTheVarianceOfEachPart) {
  const ErrorSample mean = MeanOf(SampleErrors(MakeTable(0.1, 0.0), Choosing(kRung), kOne));
  // 400 samples tell a variance to 7 %, and outliers are cut; k1 and k2 have those of H and of the difference.
  EXPECT_NEAR(mean.noise[kMeanPart], 0.01, 0.002);
  EXPECT_NEAR(mean.noise[kFirstPart], 0.02, 0.004);
  EXPECT_NEAR(mean.noise[kSecondPart], 0.02, 0.004);
  EXPECT_NEAR(mean.noise[kTurnPart], 0.01, 0.002);
  // Three standard deviations of the mean of 400 products of what two rungs differ by in each half.
  EXPECT_NEAR(mean.detail[kMeanPart], 0.0, 0.008) << "noise of halves is independent";
}

TEST(ErrorSamplesTest, TheVarianceIsThatOfTheCountThatIsUsed) {
  const PilotTable table = MakeTable(0.1, 0.0);
  const double half[] = {0.5};
  EXPECT_DOUBLE_EQ(SampleErrors(table, Choosing(kRung), half)[7].noise[kMeanPart],
                   0.5 * SampleErrors(table, Choosing(kRung), kOne)[7].noise[kMeanPart]);
}

TEST(ErrorSamplesTest, HalvesThatChoseTheWeightsOfTheTracelessPartTellTooLittleOfItsNoise) {
  const PilotTable table = MakeTable(0.1, 0.0);
  ScaleChoice choice = Choosing(kRung);
  for (ScaleWeights* const weights : {&choice.weights.mean, &choice.weights.traceless, &choice.weights.gaussian}) {
    weights->trends = {{1.0, 1.0, 0.0}};
    weights->local_differences.assign(table.size(), {1.0f});
  }
  const ErrorSample own = SampleErrors(table, choice, kOne)[7];
  choice.weights.traceless.trends.clear();
  const ErrorSample shared = SampleErrors(table, choice, kOne)[7];
  EXPECT_DOUBLE_EQ(own.noise[kMeanPart], shared.noise[kMeanPart]);
  EXPECT_NEAR(own.noise[kTurnPart] / shared.noise[kTurnPart], 1.5, 1e-9);
}

TEST(ErrorSamplesTest, WhatSmoothingTakesIsSeenThroughTheNoise) {
  // The next rung takes 1.41 times as much: 0.41 times as much more, and 1.35^2 for safety.
  constexpr double kLost = 0.2;
  const double difference = kLost * (static_cast<double>(kScaleRungs[kRung + 1]) / kScaleRungs[kRung] - 1.0);
  const ErrorSample mean = MeanOf(SampleErrors(MakeTable(0.02, kLost), Choosing(kRung), kOne));
  for (const ShapePart part : {kMeanPart, kFirstPart, kSecondPart}) {
    EXPECT_NEAR(mean.detail[part] / (1.35 * 1.35 * difference * difference), 1.0, 0.15);
  }
  EXPECT_NEAR(mean.detail[kTurnPart], 0.0, 0.001);
  EXPECT_NEAR(mean.lean, -difference, 0.01) << "the estimate is too small";
}

TEST(ErrorSamplesTest, WhereChangesHardlyGrowTheErrorIsAsManyTimesThem) {
  const PilotTable table = MakeTable(0.02, 0.2);
  ScaleChoice choice = Choosing(kRung);
  const ErrorSample smooth = MeanOf(SampleErrors(table, choice, kOne));
  choice.scores.front().bias_per_change = 2.5;
  const ErrorSample detailed = MeanOf(SampleErrors(table, choice, kOne));
  EXPECT_NEAR(detailed.detail[kMeanPart] / smooth.detail[kMeanPart], 2.5 * 2.5, 1e-6);
  EXPECT_NEAR(detailed.lean / smooth.lean, 2.5, 1e-6);
  // That of a smooth surface is the least.
  choice.scores.front().bias_per_change = 0.5;
  EXPECT_EQ(MeanOf(SampleErrors(table, choice, kOne)).detail[kMeanPart], smooth.detail[kMeanPart]);
}

TEST(ErrorSamplesTest, JetsOfDegreeSixLoseLessThanTheirNextScale) {
  constexpr double kLost = 0.2;
  const PilotTable table = MakeTable(0.0, kLost);
  PilotTable sextic = table;
  for (size_t i = 0; i < table.size(); ++i) {
    for (const auto estimates : {&PilotPoint::mean, &PilotPoint::difference, &PilotPoint::twist}) {
      (sextic[i].*estimates)[kSexticMethod] = (table[i].*estimates)[kRegressionMethod];
    }
  }
  ScaleChoice choice = Choosing(kRung);
  const double regression = MeanOf(SampleErrors(table, choice, kOne)).detail[kMeanPart];
  choice.chosen.front().method = kSexticMethod;
  const double growth = std::sqrt(8.0);
  EXPECT_NEAR(
      MeanOf(SampleErrors(sextic, choice, kOne)).detail[kMeanPart] * (growth - 1.0) * (growth - 1.0) / regression, 1.0,
      1e-6);
}

// The 95 % quantile of Student's distribution with 12 degrees of freedom over that of the Gaussian one.
constexpr double kStudent = 1.782 / 1.645;

TEST(ErrorSamplesTest, WithoutHalvesTheChangesTellTheNoise) {
  // In this table the noise of one rung is independent of that of the next, which is half as large.
  const ErrorSample mean = MeanOf(SampleErrors(MakeTable(0.1, 0.0, kRung + 1), Choosing(kRung), kOne));
  EXPECT_EQ(mean.noise[kMeanPart], 0.0);
  EXPECT_NEAR(mean.detail[kMeanPart] / (kStudent * kStudent), 0.01, 0.003);
}

TEST(ErrorSamplesTest, WithoutHalvesTheChangesTellTheBias) {
  // What is lost doubles from one scale of hexagrams to the next, as theory has it.
  constexpr double kLost = 0.2;
  PilotTable table = MakeTable(0.0, kLost, kRung + 1);
  for (PilotPoint& point : table) {
    for (const auto estimates : {&PilotPoint::mean, &PilotPoint::difference, &PilotPoint::twist}) {
      (point.*estimates)[kHexagramMethod] = (point.*estimates)[kRegressionMethod];
    }
  }
  ScaleChoice choice = Choosing(kRung);
  choice.chosen.front().method = kHexagramMethod;
  const ErrorSample mean = MeanOf(SampleErrors(table, choice, kOne));
  // The root of 2 times the count of a rung is rounded to whole numbers.
  EXPECT_NEAR(std::sqrt(mean.detail[kMeanPart]) / kLost, kStudent, 0.01);
}

TEST(ErrorSamplesTest, SamplesWhoseNeighborhoodsOverlapTellLess) {
  // The 12 nearest of points on a line, 1 apart, lie within 6 of most of them.
  const auto detail_with = [](double radius, size_t method) {
    PilotTable table = MakeTable(0.0, 0.2, kRung + 1);
    for (PilotPoint& point : table) {
      point.radius.fill(static_cast<float>(radius));
      for (const auto estimates : {&PilotPoint::mean, &PilotPoint::difference, &PilotPoint::twist}) {
        (point.*estimates)[method] = (point.*estimates)[kRegressionMethod];
      }
    }
    ScaleChoice choice = Choosing(kRung);
    choice.chosen.front().method = method;
    return std::sqrt(SampleErrors(table, choice, kOne)[200].detail[kMeanPart]);
  };
  // Two are independent where the radius is 6: Student's 95 % quantile is 2.920.
  const double apart = detail_with(0.1, kRegressionMethod), overlapping = detail_with(6.0, kRegressionMethod);
  EXPECT_NEAR(overlapping / apart, 2.920 / 1.782, 0.025);
  EXPECT_DOUBLE_EQ(detail_with(6.0, kQuarticMethod), detail_with(0.1, kQuarticMethod));
}

// Where one half of a cloud has noise and the other a bias, each is told by its own changes.
TEST(ErrorSamplesTest, WithoutHalvesEachPlaceHasItsOwnErrors) {
  const PilotTable noisy = MakeTable(0.1, 0.0, kRung + 1), smooth = MakeTable(0.0, 1e-3, kRung + 1);
  PilotTable table(noisy.begin(), noisy.begin() + 200);
  table.insert(table.end(), smooth.begin() + 200, smooth.end());
  const std::vector<ErrorSample> mixed = SampleErrors(table, Choosing(kRung), kOne);
  const std::vector<ErrorSample> alone = SampleErrors(smooth, Choosing(kRung), kOne);
  EXPECT_DOUBLE_EQ(mixed[300].detail[kMeanPart], alone[300].detail[kMeanPart]);
}

TEST(ErrorSamplesTest, WithoutHalvesErrorsOfCandidatesAddWithOneSign) {
  PilotTable table = MakeTable(0.0, 0.2, kRungCount);
  for (PilotPoint& point : table) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      // The same change, the other way.
      point.mean[kQuarticMethod][rung][PilotPoint::kAll] = -point.mean[kRegressionMethod][rung][PilotPoint::kAll];
      for (const auto estimates : {&PilotPoint::difference, &PilotPoint::twist}) {
        (point.*estimates)[kQuarticMethod][rung] = (point.*estimates)[kRegressionMethod][rung];
      }
    }
  }
  ScaleChoice choice = Choosing(kRung);
  const double alone = MeanOf(SampleErrors(table, choice, kOne)).detail[kMeanPart];
  choice.chosen.push_back({kQuarticMethod, kRung});
  choice.weights.mean.cloud_weights = choice.weights.traceless.cloud_weights = {0.5, 0.5};
  const double factors[] = {1.0, 1.0};
  const double both = MeanOf(SampleErrors(table, choice, factors)).detail[kMeanPart];
  EXPECT_NEAR(both / alone, 1.0, 0.2) << "signed, they would cancel out";
}

TEST(ErrorSamplesTest, RoundingIsBelowABiasOfExactPositions) {
  // Radii of 0.1: four units in the last place of a normal, over them.
  EXPECT_NEAR(SampleErrors(MakeTable(0.0, 0.0), Choosing(kRung), kOne)[0].floor / 0x1p-22, 10.0, 0.01);
}

TEST(ErrorSamplesTest, TheLastRungGoesOnAsTheOneBefore) {
  const PilotTable table = MakeTable(0.0, 0.01);
  const ErrorSample last = MeanOf(SampleErrors(table, Choosing(kRungCount - 1), kOne));
  const ErrorSample before = MeanOf(SampleErrors(table, Choosing(kRungCount - 2), kOne));
  const double growth = static_cast<double>(kScaleRungs[kRungCount - 1]) / kScaleRungs[kRungCount - 2];
  EXPECT_NEAR(last.detail[kMeanPart] / before.detail[kMeanPart], growth * growth, 1e-3);
}

TEST(ErrorSamplesTest, NoiseInThePositionsCountsByTheSlopeOfTheSurface) {
  PilotTable table = MakeTable(0.0, 0.0);
  for (PilotPoint& point : table) {
    for (auto& parts : point.slope) parts.fill({2.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f});  // of H, along x and y
  }
  const ErrorSample mean = MeanOf(SampleErrors(table, Choosing(kRung, 0.1), kOne));
  for (const ShapePart part : {kMeanPart, kFirstPart, kSecondPart}) EXPECT_NEAR(mean.place[part], 0.05, 1e-6);
  EXPECT_NEAR(mean.place[kTurnPart], 0.0, 1e-9);
}

TEST(ErrorSamplesTest, APointWithoutEstimatesIsNotKnown) {
  PilotTable table = MakeTable(0.1, 0.1);
  table[3] = PilotPoint({3.0f, 0.0f, 0.0f});
  const std::vector<ErrorSample> samples = SampleErrors(table, Choosing(kRung), kOne);
  EXPECT_FALSE(samples[3].is_known);
  EXPECT_TRUE(samples[4].is_known);
  EXPECT_FALSE(SampleErrors(std::span(&table[3], 1), Choosing(kRung), kOne)[0].is_known);
}

}  // namespace
}  // namespace curvd::testing
