#include "core/scale/judging/position_noise.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "core/scale/pilot/pilot_table.h"

namespace curvd::testing {
namespace {

// Points without estimates, with a radius of 1 and a residual of 0.2 at every rung.
PilotTable Residuals() {
  PilotTable table;
  for (int i = 0; i < 100; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    point.radius.fill(1.0f);
    point.residual.fill(0.2f);
    table.push_back(point);
  }
  return table;
}

double SigmaOf(const PilotTable& table) { return PositionNoise(table).value_or(0.0); }

void SetResidual(size_t rung, float residual, PilotTable& table) {
  for (PilotPoint& point : table) point.residual[rung] = residual;
}

TEST(PositionNoiseTest, NoiseIsTheLeastResidualSinceDetailOnlyAdds) {
  PilotTable table = Residuals();
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.2f);
  SetResidual(5, 0.1f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.1f);
}

TEST(PositionNoiseTest, NoiseIsNotToldFromNeighborhoodsTooSmallForTheJet) {
  PilotTable table = Residuals();
  SetResidual(0, 0.01f, table);
  SetResidual(1, 0.01f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.2f);
  SetResidual(2, 0.01f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.01f);
}

TEST(PositionNoiseTest, NoiseIsNotToldFromNeighborhoodsLessThanFourTimesAsLarge) {
  PilotTable table = Residuals();
  for (PilotPoint& point : table) {
    point.radius.fill(0.7f);  // 3.5 times the residual
    point.radius[8] = 0.9f;
    point.residual[8] = 0.21f;  // 4.3 times
  }
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.21f);
  for (PilotPoint& point : table) point.radius[8] = 0.8f;  // 3.8 times: no rung is left
  EXPECT_EQ(SigmaOf(table), 0.0);
}

TEST(PositionNoiseTest, PositionsAreExactIfNoiseIsNothingBesideTheSmallestNeighborhoods) {
  PilotTable table = Residuals();
  EXPECT_FALSE(PositionsAreExact(table));
  SetResidual(4, 0.0009f, table);
  EXPECT_TRUE(PositionsAreExact(table));
  for (PilotPoint& point : table) point.radius[0] = 0.8f;
  EXPECT_FALSE(PositionsAreExact(table));
}

TEST(PositionNoiseTest, WhereNoJetTellsItNobodyKnows) {
  PilotTable table = Residuals();
  for (PilotPoint& point : table) point.residual.fill(std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(PositionNoise(table).has_value());
  EXPECT_FALSE(PositionsAreExact(table));
}

}  // namespace
}  // namespace curvd::testing
