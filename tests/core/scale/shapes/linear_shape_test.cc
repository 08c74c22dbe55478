#include "core/scale/shapes/linear_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace curvd::testing {
namespace {

// Points on a cylinder of radius 0.3 along y, up to an angle from the top of it, where the origin is.
PilotSums Cylinder(size_t count, double most_angle, double noise = 0.0) {
  std::mt19937_64 random(count);
  std::uniform_real_distribution<double> angle(-most_angle, most_angle), along(-1.0, 1.0);
  std::normal_distribution<double> gaussian(0.0, noise);
  const auto shaken = [&](double v) { return noise > 0.0 ? v + gaussian(random) : v; };
  PilotSums sums;
  for (size_t i = 0; i < count; ++i) {
    const double a = angle(random), x = std::sin(a), z = std::cos(a);
    double n[3] = {shaken(x), shaken(0.0), shaken(z)};
    const double length = std::hypot(n[0], n[1], n[2]);
    sums.Add({{0.3 * x, along(random), 0.3 * z - 0.3}, {n[0] / length, n[1] / length, n[2] / length}});
  }
  return sums;
}

TEST(LinearShapeTest, IsExactOnCylindersHoweverFarAround) {
  for (const double most_angle : {0.1, 1.0, std::numbers::pi}) {
    const auto shape = LinearShapeOf(Cylinder(60, most_angle), 60);
    ASSERT_TRUE(shape.has_value()) << most_angle;
    EXPECT_NEAR(shape->mean, 0.5 / 0.3, 1e-6);
    EXPECT_NEAR(shape->difference, 0.5 / 0.3, 1e-6);
    EXPECT_NEAR(shape->twist, 0.0, 1e-6);
  }
}

TEST(LinearShapeTest, TakesNoiseOfNormalsAwayWithoutShorteningThem) {
  const auto shape = LinearShapeOf(Cylinder(20'000, std::numbers::pi, 0.2), 20'000);
  ASSERT_TRUE(shape.has_value());
  EXPECT_NEAR(shape->mean, 0.5 / 0.3, 0.02);
}

TEST(LinearShapeTest, ThereIsNoneOfFewOrOnALine) {
  EXPECT_FALSE(LinearShapeOf(PilotSums(), 0.0).has_value());
  EXPECT_FALSE(LinearShapeOf(Cylinder(7, 1.0), 7.0).has_value());
  EXPECT_FALSE(LinearShapeOf(Cylinder(20, 1.0), 7.0).has_value()) << "13 of 20 are copies";
  PilotSums line;
  for (int i = 0; i < 40; ++i) line.Add({{0.01 * i, 0.02 * i, 0.0}, {0.0, 0.0, 1.0}});
  EXPECT_FALSE(LinearShapeOf(line, 40.0).has_value());
}

TEST(LinearShapeTest, ThereIsNoneOfNormalsThatContradictTheFrame) {
  PilotSums down;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) down.Add({{coordinate(random), coordinate(random), 0.0}, {0.0, 0.0, -1.0}});
  EXPECT_FALSE(LinearShapeOf(down, 40.0).has_value());
}

}  // namespace
}  // namespace curvd::testing
