#include "core/scale/detail/near_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace curvd::testing {
namespace {

constexpr size_t kChosen = 12, kNear = 2, kMiddle = 6;

// Samples whose mean curvature, by the regression of degree 3, has this noise at each of the rungs, which halves where
// neighbors are twice as many, and by jets of degree 4 so many times that.
PilotTable Samples(double noise, double times_of_jets) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> gaussian(0.0, noise);
  PilotTable samples;
  for (int i = 0; i < 400; ++i) {
    PilotPoint& point = samples.emplace_back(std::array<float, 3>{});
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const double falls = std::exp2(-0.5 * static_cast<double>(rung));
      point.radius[rung] = static_cast<float>(0.1 / falls);
      point.normal_residual[rung] = 0.1f;
      point.mean[kRegressionMethod][rung][PilotPoint::kAll] = static_cast<float>(1.0 + falls * gaussian(random));
      point.mean[kQuarticMethod][rung][PilotPoint::kAll] =
          static_cast<float>(1.0 + times_of_jets * falls * gaussian(random));
    }
  }
  return samples;
}

// Of the regression with that rung; its noise is `noise` at the first rung, and falls.
ScaleChoice RegressionAt(size_t chosen, double noise) {
  ScaleChoice choice;
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const double at = noise * std::exp2(-0.5 * static_cast<double>(rung));
    choice.scores.push_back({{kRegressionMethod, rung}, at, at, at, 0.0, rung == chosen ? 1.0 : 0.0});
    choice.scores.push_back({{kQuarticMethod, rung}, at, at, at, 0.0, 0.0});
  }
  choice.chosen = {{kRegressionMethod, chosen}};
  choice.weights.mean.cloud_weights = {1.0};
  return choice;
}

TEST(NearCheckTest, ToleratesAFewStandardDeviationsOfNoise) {
  const auto checks = FindNearChecks(Samples(0.1, 3.0), RegressionAt(kChosen, 0.1), 16);
  ASSERT_EQ(checks.size(), 2u);
  EXPECT_EQ(checks[0].candidate, (ScaleCandidate{kRegressionMethod, kNear}));
  EXPECT_EQ(checks[1].candidate, (ScaleCandidate{kRegressionMethod, kMiddle}));
  EXPECT_TRUE(checks[0].is_noise);
  EXPECT_NEAR(checks[0].most_difference, 3.8 * 0.05, 0.03);
  EXPECT_NEAR(checks[1].most_difference, 3.8 * 0.0125, 0.008);
}

TEST(NearCheckTest, TakesJetsWherePositionsTellMore) {
  const auto checks = FindNearChecks(Samples(0.1, 0.1), RegressionAt(kChosen, 0.1), 16);
  ASSERT_EQ(checks.size(), 2u);
  EXPECT_EQ(checks[0].candidate.method, kQuarticMethod);
}

TEST(NearCheckTest, KeepsMoreRoomWhereNoNoiseDecides) {
  ScaleChoice exact = RegressionAt(kChosen, 0.1);
  for (ScaleScore& score : exact.scores) score.noise = 0.1;
  const auto checks = FindNearChecks(Samples(0.1, 3.0), exact, 16);
  ASSERT_EQ(checks.size(), 2u);
  EXPECT_FALSE(checks[0].is_noise);
  EXPECT_NEAR(checks[0].most_difference, 5.0 / 3.0 * 3.8 * 0.05, 0.05);
}

TEST(NearCheckTest, IsFarBelowWhatIsChosen) {
  const PilotTable samples = Samples(0.1, 3.0);
  EXPECT_EQ(FindNearChecks(samples, RegressionAt(kMiddle, 0.1), 16).size(), 1u);
  EXPECT_TRUE(FindNearChecks(samples, RegressionAt(kMiddle - 1, 0.1), 16).empty());
  EXPECT_EQ(FindNearChecks(samples, RegressionAt(kChosen, 0.1), 64).size(), 1u) << "the caller wants 64 neighbors";
  EXPECT_TRUE(FindNearChecks(samples, ScaleChoice(), 16).empty());
  EXPECT_TRUE(FindNearChecks(PilotPoints(samples).first(20), RegressionAt(kChosen, 0.1), 16).empty());
}

}  // namespace
}  // namespace curvd::testing
