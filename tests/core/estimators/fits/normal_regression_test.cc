// The local regression of normals against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

using NormalRegressionTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, NormalRegressionTest, InstructionSets(), InstructionSetName);

EstimatorOptions Options(uint32_t k) {
  EstimatorOptions options;
  options.estimator = "normal-regression";
  options.neighborhood = NeighborCount{k};
  return options;
}

TEST_P(NormalRegressionTest, MatchesTheDoubleOracle) {
  for (uint32_t k : {25u, 50u, 300u}) {
    ExpectNearReference(Sphere(2000, 3.0), Options(k), 11);
    ExpectNearReference(Waves(2000, 0.0, k), Options(k), 11);
    ExpectNearReference(Waves(2000, 0.01, k), Options(k), 11);
  }
}

TEST_P(NormalRegressionTest, LargeNeighborhoodsMatchTheDoubleOracle) {
  ExpectNearReference(Waves(6000, 0.01, 1), Options(2048), 401);
}

TEST_P(NormalRegressionTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options = Options(50);
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Sphere(2000, 3.0), options, 11);
}

// A band around a part of a cylinder of radius 1, much longer than wide, askew to the axes.
TestPoints Band(size_t points, double half_width) {
  TestPoints band;
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> spread(-1.0, 1.0);
  for (size_t i = 0; i < points; ++i) {
    const double angle = spread(engine), along = half_width * spread(engine), root = std::sqrt(0.5);
    const double x = std::cos(angle), y = std::sin(angle);
    band.Add(x, root * (y + along), root * (y - along), x, root * y, root * y);
  }
  return band;
}

TEST_P(NormalRegressionTest, NarrowBandsMatchTheDoubleOracle) {
  ExpectNearReference(Band(3000, 0.02), Options(300), 7);
}

TEST_P(NormalRegressionTest, FewNeighborsAreFittedInALowerDegree) {
  const TestPoints sphere = Sphere(2000, 3.0);
  for (uint32_t k = 5; k <= 14; ++k) {
    const EstimationResult result = MustEstimate(sphere.ToCloud(), Options(k));
    size_t ok = 0;
    for (const PointCurvature& point : result.field.points.span()) {
      if (point.status != PointStatus::kOk) {
        ASSERT_EQ(point.status, PointStatus::kSingularFit);
        continue;
      }
      ++ok;
      ASSERT_NEAR(point.mean, 1.0 / 3.0, 0.02) << k;
    }
    EXPECT_GT(ok, 1980u) << k;
  }
}

TEST_P(NormalRegressionTest, RowsOfPointsHaveTheCurvatureThatTheyDetermine) {
  // Two rows along a cylinder's circles tell nothing of y^2 and beyond.
  TestPoints rows;
  for (int i = 0; i < 1000; ++i) {
    const double angle = 0.003 * (i / 2);
    rows.Add(std::cos(angle), std::sin(angle), 0.02 * (i % 2), std::cos(angle), std::sin(angle), 0.0);
  }
  const EstimationResult result = MustEstimate(rows.ToCloud(), Options(50));
  for (const PointCurvature& point : result.field.points.span()) {
    ASSERT_EQ(point.status, PointStatus::kOk);
    ASSERT_NEAR(point.k1, 0.0, 1e-3);
    ASSERT_NEAR(point.k2, 1.0, 1e-2);
  }
}

TEST_P(NormalRegressionTest, PlanesAreFlat) {
  TestPoints plane = RandomPoints(Layout::kCoplanar, 2000, 5);
  for (auto& normal : plane.normals) normal = {0.0f, 0.0f, 1.0f};
  for (uint32_t k : {20u, 300u}) {
    const EstimationResult result = MustEstimate(plane.ToCloud(), Options(k));
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_EQ(point.status, PointStatus::kOk);
      ASSERT_LT(std::abs(point.k1) + std::abs(point.k2), 1e-5 / point.radius);
    }
  }
}

}  // namespace
}  // namespace curvd::testing
