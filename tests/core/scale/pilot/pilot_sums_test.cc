#include "core/scale/pilot/pilot_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/scale/pilot/pilot_fits.h"

namespace curvd::testing {
namespace {

// The fits of a neighborhood of that radius.
PilotFits FitsOf(const PilotSums& sums, double radius) {
  PilotFitter fitter;
  fitter.Add(sums, radius);
  return fitter.Fit().front();
}

// Neighbors on z = -(a x^2 + b y^2) / 2, seen from the origin, where the principal curvatures are a and b: a bulge
// along the normal where they are positive. Evenly spread over a disc.
PilotSums Bowl(double a, double b, size_t count, double radius) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-radius, radius);
  PilotSums sums;
  while (sums.count() < static_cast<double>(count)) {
    const double x = coordinate(random), y = coordinate(random);
    if (x * x + y * y > radius * radius) continue;
    const double length = std::sqrt(1.0 + a * a * x * x + b * b * y * y);
    sums.Add({{x, y, -0.5 * (a * x * x + b * y * y)}, {a * x / length, b * y / length, 1.0 / length}});
  }
  return sums;
}

TEST(PilotSumsTest, EveryMethodFindsTheCurvatureOfAGraph) {
  for (const auto& [a, b] : {std::pair{0.2, 0.2}, std::pair{0.3, -0.1}, std::pair{-0.4, -0.1}}) {
    const PilotSums sums = Bowl(a, b, 400, 0.5);
    const double mean = 0.5 * (a + b);
    ASSERT_TRUE(sums.HexagramEstimate().has_value());
    EXPECT_NEAR(sums.HexagramEstimate()->shape.mean, mean, 0.02);
    EXPECT_NEAR(sums.HexagramEstimate()->steepest, std::max(std::abs(a), std::abs(b)), 0.03);
    EXPECT_NEAR(FitsOf(sums, 0.5).regression->shape.mean, mean, 1e-4);
    EXPECT_NEAR(FitsOf(sums, 0.5).quadratic_regression->mean, mean, 0.01) << "half of the graph's bend is of degree 3";
    EXPECT_NEAR(FitsOf(sums, 0.5).quartic->shape.mean, mean, 1e-10) << "the graph is a polynomial of degree 2";
    EXPECT_LT(FitsOf(sums, 0.5).quartic->residual, 1e-7);
    EXPECT_NEAR(FitsOf(sums, 0.5).quadric->shape.mean, mean, 1e-10);
    EXPECT_NEAR(FitsOf(sums, 0.5).sextic->shape.mean, mean, 1e-10);
  }
}

TEST(PilotSumsTest, EveryMethodFindsTheShapeOperatorOfAGraph) {
  const PilotSums sums = Bowl(0.3, -0.1, 400, 0.5);
  for (const TangentShape& shape :
       {sums.HexagramEstimate()->shape, FitsOf(sums, 0.5).regression->shape, FitsOf(sums, 0.5).quartic->shape}) {
    EXPECT_NEAR(shape.difference, 0.2, 0.02) << "hexagrams of 400 random points are off by as much";
    EXPECT_NEAR(shape.twist, 0.0, 0.02);
  }
  EXPECT_NEAR(FitsOf(sums, 0.5).regression->shape.difference, 0.2, 1e-3);
  EXPECT_NEAR(FitsOf(sums, 0.5).quadratic_regression->difference, 0.2, 0.01);
  EXPECT_NEAR(FitsOf(sums, 0.5).quartic->shape.difference, 0.2, 1e-10);
  EXPECT_NEAR(FitsOf(sums, 0.5).quadric->shape.difference, 0.2, 1e-10);
  EXPECT_NEAR(FitsOf(sums, 0.5).sextic->shape.difference, 0.2, 1e-10);
}

// Normals that are a polynomial of degree 2 over the tangent plane, but for their length.
TEST(PilotSumsTest, QuadraticRegressionsFollowNormalsOfDegreeTwo) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> coordinate(-0.01, 0.01);
  PilotSums sums;
  for (int i = 0; i < 60; ++i) {
    const double x = coordinate(random), y = coordinate(random);
    const double nx = 0.4 * x + 2.0 * x * y, ny = 0.2 * y + x * x, length = std::sqrt(1.0 + nx * nx + ny * ny);
    sums.Add({{x, y, 0.0}, {nx / length, ny / length, 1.0 / length}});
  }
  const TangentShape shape = *FitsOf(sums, 0.015).quadratic_regression;
  EXPECT_NEAR(shape.mean, 0.3, 1e-5);
  EXPECT_NEAR(shape.difference, 0.1, 1e-5);
  EXPECT_NEAR(shape.twist, 0.0, 1e-5);
}

TEST(PilotSumsTest, JetsOfDegreeSixFollowWhatThoseOfDegreeFourCannot) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
  PilotSums sums;
  for (int i = 0; i < 100; ++i) {
    const double x = coordinate(random), y = coordinate(random);
    sums.Add({{x, y, -0.2 * x * x - 0.1 * y * y + x * x * y * y * y * y - y * y * y * y * y * y}, {0, 0, 1}});
  }
  EXPECT_NEAR(FitsOf(sums, 0.7).sextic->shape.mean, 0.3, 1e-9);
  EXPECT_GT(std::abs(FitsOf(sums, 0.7).quartic->shape.mean - 0.3), 1e-3);
}

TEST(PilotSumsTest, JetsOfDegreeSixWantHalfAsManyNeighborsMoreThanCoefficients) {
  EXPECT_FALSE(FitsOf(Bowl(0.2, 0.1, 41, 1.0), 1.0).sextic.has_value());
  EXPECT_TRUE(FitsOf(Bowl(0.2, 0.1, 42, 1.0), 1.0).sextic.has_value());
}

// Normals whose derivative is [[x, y / 2], [y / 2, 3 y]] over the tangent plane.
TEST(PilotSumsTest, TheRegressionTellsHowTheShapeChanges) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
  PilotSums sums;
  for (int i = 0; i < 500; ++i) {
    const double x = coordinate(random), y = coordinate(random);
    const double nx = 0.5 * x * x + 0.25 * y * y, ny = 0.5 * x * y + 1.5 * y * y,
                 length = std::sqrt(1 + nx * nx + ny * ny);
    sums.Add({{x, y, 0.0}, {nx / length, ny / length, 1.0 / length}});
  }
  const auto slope = FitsOf(sums, 0.15).regression->slope;
  EXPECT_NEAR(slope[0].mean, 0.75, 1e-3);
  EXPECT_NEAR(slope[0].difference, 0.25, 1e-3);
  EXPECT_NEAR(slope[0].twist, 0.0, 1e-3);
  EXPECT_NEAR(slope[1].mean, 1.5, 1e-3);
  EXPECT_NEAR(slope[1].difference, -1.5, 1e-3);
  EXPECT_NEAR(slope[1].twist, 0.5, 1e-3);
}

TEST(PilotSumsTest, TheResidualOfTheNormalsIsTheirNoise) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> coordinate(-0.7, 0.7);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (const int count : {64, 2000}) {
    double squares = 0.0;
    constexpr int kTrials = 20;
    for (int trial = 0; trial < kTrials; ++trial) {
      PilotSums sums;
      for (int i = 0; i < count; ++i) {
        const double nx = noise(random), ny = noise(random), length = std::sqrt(1 + nx * nx + ny * ny);
        sums.Add({{coordinate(random), coordinate(random), 0}, {nx / length, ny / length, 1 / length}});
      }
      const double residual = FitsOf(sums, 1.0).regression->residual;
      squares += residual * residual / kTrials;
    }
    EXPECT_NEAR(std::sqrt(squares), 0.05, 0.003) << count;
  }
}

TEST(PilotSumsTest, SumsOfPartsAreThoseOfTheWhole) {
  PilotSums parts = Bowl(0.2, 0.1, 60, 1.0);
  parts += Bowl(0.2, 0.1, 40, 1.0);
  EXPECT_EQ(parts.count(), 100.0);
  EXPECT_NEAR(FitsOf(parts, 1.0).quartic->shape.mean, 0.15, 1e-9);
}

TEST(PilotSumsTest, TheResidualIsTheNoiseOfThePositions) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  PilotSums sums;
  for (int i = 0; i < 2000; ++i) sums.Add({{coordinate(random), coordinate(random), noise(random)}, {0, 0, 1}});
  EXPECT_NEAR(FitsOf(sums, 1.0).quartic->residual, 0.01, 0.0005);
}

// A spread of points of a normal distribution, along two axes of the tangent plane, turned, and along the normal.
PilotSums Spread(double along, double across, double thickness) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> draw;
  PilotSums sums;
  for (int i = 0; i < 1000; ++i) {
    const double a = along * draw(random), b = across * draw(random);
    sums.Add({{0.6 * a - 0.8 * b, 0.8 * a + 0.6 * b, thickness * draw(random)}, {0, 0, 1}});
  }
  return sums;
}

TEST(PilotSumsTest, TellsALineFromANarrowStripAndFromNoise) {
  EXPECT_TRUE(Spread(0.5, 0.01, 0.01).LieAlongLine());
  EXPECT_TRUE(Spread(0.5, 0.0, 0.0).LieAlongLine());
  EXPECT_TRUE(Spread(0.5, 0.01, 0.1).LieAlongLine()) << "a bent line is as thick as its bend";
  EXPECT_FALSE(Spread(0.5, 0.01, 0.001).LieAlongLine()) << "a strip";
  EXPECT_FALSE(Spread(0.5, 0.2, 0.5).LieAlongLine()) << "noise as large as the neighborhood";
  EXPECT_FALSE(Bowl(0.9, 0.1, 400, 1.0).LieAlongLine());
}

TEST(PilotSumsTest, NothingIsSaidWhereTheNeighborsFixNoSurface) {
  EXPECT_FALSE(PilotSums().HexagramEstimate().has_value());
  EXPECT_FALSE(FitsOf(PilotSums(), 1.0).regression.has_value());
  EXPECT_FALSE(FitsOf(PilotSums(), 1.0).quartic.has_value());
  EXPECT_FALSE(FitsOf(PilotSums(), 1.0).quadric.has_value());
  PilotSums line, spot, opposed;
  for (int i = 0; i < 100; ++i) {
    line.Add({{0.01 * i, 0.0, 0.0}, {0, 0, 1}});
    spot.Add({{0.0, 0.0, 0.0}, {0, 0, 1}});
    opposed.Add({{std::cos(i), std::sin(i), 0.0}, {0, 0, i % 2 == 0 ? 1.0 : -1.0}});
  }
  for (const PilotSums* sums : {&line, &spot}) {
    EXPECT_FALSE(sums->HexagramEstimate().has_value());
    EXPECT_FALSE(FitsOf(*sums, 1.0).regression.has_value());
    EXPECT_FALSE(FitsOf(*sums, 1.0).quartic.has_value());
    EXPECT_FALSE(FitsOf(*sums, 1.0).sextic.has_value());
  }
  EXPECT_FALSE(FitsOf(opposed, 1.0).regression.has_value()) << "normals cancel out";
}

}  // namespace
}  // namespace curvd::testing
