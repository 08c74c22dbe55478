#include "core/scale/scale_judge.h"

#include <gtest/gtest.h>

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

double SigmaOf(const PilotTable& table) {
  return ScaleJudge(table, ScaleBounds{}, ScaleJudge::Quantity::kMean).sigma();
}

void SetResidual(size_t rung, float residual, PilotTable& table) {
  for (PilotPoint& point : table) point.residual[rung] = residual;
}

TEST(ScaleJudgeTest, NoiseIsTheLeastResidualSinceDetailOnlyAdds) {
  PilotTable table = Residuals();
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.2f);
  SetResidual(5, 0.1f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.1f);
}

TEST(ScaleJudgeTest, NoiseIsNotToldFromNeighborhoodsTooSmallForTheJet) {
  PilotTable table = Residuals();
  SetResidual(0, 0.01f, table);
  SetResidual(1, 0.01f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.2f);
  SetResidual(2, 0.01f, table);
  EXPECT_FLOAT_EQ(SigmaOf(table), 0.01f);
}

TEST(ScaleJudgeTest, NoiseIsNotToldFromNeighborhoodsLessThanFourTimesAsLarge) {
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

}  // namespace
}  // namespace curvd::testing
