#include "client/neighbors/scaled_positions.h"

#include <gtest/gtest.h>

namespace curv {
namespace {

TEST(ScaleToUnitTest, TheLargestCoordinateComesBelowTwo) {
  for (const int exponent : {-1074, -1000, -3, 0, 5, 1000, 1023}) {
    const double size = std::ldexp(1.0, exponent);
    std::vector<Vec3> positions = {{size, 0, 0}, {0, -size, 0}};
    ScaleToUnit(positions);
    EXPECT_EQ(positions, (std::vector<Vec3>{{1, 0, 0}, {0, -1, 0}})) << exponent;
  }
  std::vector<Vec3> positions = {{12, 0.375, -15}};
  ScaleToUnit(positions);
  EXPECT_EQ(positions[0], (Vec3{1.5, 0.046875, -1.875}));
}

TEST(ScaleToUnitTest, ZeroStaysZero) {
  std::vector<Vec3> positions = {{0, 0, 0}, {0, 0, 0}};
  ScaleToUnit(positions);
  EXPECT_EQ(positions, std::vector<Vec3>(2));
  positions.clear();
  ScaleToUnit(positions);
  EXPECT_TRUE(positions.empty());
}

}  // namespace
}  // namespace curv
