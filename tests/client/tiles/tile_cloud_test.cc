#include "client/tiles/tile_cloud.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/tiles/lattice.h"

namespace curv {
namespace {

constexpr double kSpacing = 0x1p-10;

// Two points that are `steps` of the lattice apart, far from zero.
FloatArrays TwoPoints(double steps, bool is_double) {
  TilePlan plan;
  plan.is_double = is_double;
  plan.spacing = is_double ? kSpacing : 0.0;
  TileCloud cloud;
  cloud.points.resize(2);
  for (const size_t i : {0, 1}) {
    cloud.points[i].position = {1024.0 + static_cast<double>(i) * steps * kSpacing, 2048.0, -512.0};
    cloud.points[i].id = i;
  }
  return ToFloats(plan, cloud);
}

TEST(ToFloatsTest, TellsTheLatticeOnWhichPositionsOfDoublesAre) {
  const FloatArrays arrays = TwoPoints(2.0 * (kMostSteps - 1.0), true);
  EXPECT_EQ(arrays.spacing, kSpacing);
  EXPECT_EQ(arrays.coarse_spacing, 0.0);
  for (const size_t i : {0, 3}) EXPECT_LE(std::abs(arrays.positions[i]) / kSpacing, kMostSteps);
}

TEST(ToFloatsTest, TakesACoarserLatticeWhereThePlansIsTooFine) {
  const FloatArrays arrays = TwoPoints(2.0 * kMostSteps + 2.0, true);
  EXPECT_EQ(arrays.spacing, 2.0 * kSpacing);
  EXPECT_EQ(arrays.coarse_spacing, 2.0 * kSpacing);
}

TEST(ToFloatsTest, LeavesFloatsWhereTheyAre) {
  const FloatArrays arrays = TwoPoints(2.0, false);
  EXPECT_EQ(arrays.spacing, 0.0);
  EXPECT_EQ(arrays.positions[3], 1024.0f + 2.0f * static_cast<float>(kSpacing));
}

}  // namespace
}  // namespace curv
