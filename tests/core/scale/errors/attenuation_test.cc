#include "core/scale/errors/attenuation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace curvd::testing {
namespace {

constexpr size_t kSmoothedRung = 8, kSmoothedSamples = 400;

// Hexagrams of surfaces whose H is uniform within 5 - spread to 5 + spread, and half of whose k2 - k1 is 1. Smoothing
// takes `lost` of what H differs from 5 at kSmoothedRung, and in proportion to the number of neighbors elsewhere. At
// kSmoothedRung the halves have noise of standard deviation `noise`, at smaller rungs more.
PilotTable SmoothedTable(double spread, double lost, double noise) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  PilotTable table;
  for (size_t i = 0; i < kSmoothedSamples; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    const double departure = spread * uniform(random);
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const double growth = static_cast<double>(kScaleRungs[rung]) / kScaleRungs[kSmoothedRung];
      point.radius[rung] = static_cast<float>(std::sqrt(growth));
      std::array<double, 2> of_half;
      for (double& mean : of_half) mean = 5.0 + departure * (1.0 - lost * growth) + noise / growth * normal(random);
      const auto set = [&](PilotPoint::Part part, double mean) {
        point.mean[kHexagramMethod][rung][part] = static_cast<float>(mean);
        point.difference[kHexagramMethod][rung][part] = 1.0f;
        point.twist[kHexagramMethod][rung][part] = 0.0f;
      };
      set(PilotPoint::kAll, 0.5 * (of_half[0] + of_half[1]));
      set(PilotPoint::kEven, of_half[0]);
      set(PilotPoint::kOdd, of_half[1]);
    }
    table.push_back(point);
  }
  return table;
}

Attenuation AttenuationOf(PilotPoints table) {
  ScaleChoice choice;
  choice.chosen = {{kHexagramMethod, kSmoothedRung}};
  choice.weights.mean.cloud_weights = choice.weights.traceless.cloud_weights = {1.0};
  choice.scores = {{choice.chosen.front(), 1.0, 1.0, 1.0, 0.0, 1.0}};
  return FindAttenuation(table, choice);
}

TEST(AttenuationTest, TellsWhatSmoothingTakesOfExtremeCurvature) {
  const Attenuation found = AttenuationOf(SmoothedTable(1.0, 0.2, 0.0));
  // Of an estimate that differs by 0.8 of the truth, 0.2 of that is lost.
  EXPECT_NEAR(found.of[kMeanPart].slope, 0.25, 1e-4);
  EXPECT_NEAR(found.of[kMeanPart].mean, 5.0, 0.1);
  EXPECT_NEAR(found.of[kFirstPart].slope, 0.25, 1e-4) << "k1 is H - 1";
  EXPECT_NEAR(found.of[kSecondPart].slope, 0.25, 1e-4);
  EXPECT_NEAR(found.of[kSecondPart].mean, 6.0, 0.1);
  EXPECT_NEAR(found.of[kMeanPart].LostAt(5.8), 0.2, 0.03);
}

TEST(AttenuationTest, IsSeenThroughTheNoiseOfTheHalves) {
  EXPECT_NEAR(AttenuationOf(SmoothedTable(1.0, 0.2, 0.1)).of[kMeanPart].slope, 0.25, 0.1);
}

TEST(AttenuationTest, NoiseAloneHasNone) {
  EXPECT_EQ(AttenuationOf(SmoothedTable(1.0, 0.0, 0.1)).of[kMeanPart].slope, 0.0) << "nothing is lost";
  EXPECT_EQ(AttenuationOf(SmoothedTable(0.0, 0.0, 0.1)).of[kMeanPart].slope, 0.0) << "nothing varies";
  EXPECT_EQ(AttenuationOf(SmoothedTable(0.0, 0.0, 0.0)).of[kMeanPart].slope, 0.0);
}

TEST(AttenuationTest, NeedsHalvesAndSamples) {
  PilotTable table = SmoothedTable(1.0, 0.2, 0.0);
  EXPECT_EQ(AttenuationOf(PilotPoints(table).first(31)).of[kMeanPart].slope, 0.0);
  EXPECT_GT(AttenuationOf(PilotPoints(table).first(32)).of[kMeanPart].slope, 0.0);
  for (PilotPoint& point : table) {
    for (size_t rung = 0; rung < kSmoothedRung - 1; ++rung) {
      point.mean[kHexagramMethod][rung][PilotPoint::kOdd] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  EXPECT_EQ(AttenuationOf(table).of[kMeanPart].slope, 0.0) << "what is left is too near to compare with";
}

}  // namespace
}  // namespace curvd::testing
