// The linear regression of normals over space: against the double oracle, on each instruction set that this machine
// has, and on the surfaces that it is made for.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/seam_clouds.h"

namespace curvd::testing {
namespace {

using LinearRegressionTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, LinearRegressionTest, InstructionSets(), InstructionSetName);

EstimatorOptions LinearOptions(uint32_t k, uint32_t degree = 1) {
  EstimatorOptions options;
  options.estimator = "normal-regression";
  options.regression_degree = degree;
  options.neighborhood = NeighborCount{k};
  return options;
}

double MeanErrorBeside(const EstimationResult& result, double mean) {
  double sum = 0.0;
  for (const PointCurvature& point : result.field.points.span()) sum += std::abs(point.mean - mean);
  return sum / static_cast<double>(result.field.points.size());
}

TEST_P(LinearRegressionTest, MatchesTheDoubleOracle) {
  for (const uint32_t k : {50u, 300u}) {
    ExpectNearReference(Sphere(2000, 3.0), LinearOptions(k), 11);
    ExpectNearReference(Waves(2000, 0.0, k), LinearOptions(k), 11);
    ExpectNearReference(Waves(2000, 0.01, k), LinearOptions(k), 11);
  }
}

TEST_P(LinearRegressionTest, NoisyNormalsMatchTheDoubleOracle) {
  for (const uint32_t k : {12u, 50u, 300u}) {
    TestPoints noisy = Waves(2000, 0.01, k);
    AddNoise(0.01, 0.1, 5, noisy);
    ExpectNearReference(noisy, LinearOptions(k), 11);
  }
}

TEST_P(LinearRegressionTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options = LinearOptions(50);
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Waves(2000, 0.01, 1), options, 11);
}

TEST_P(LinearRegressionTest, IsExactAllTheWayAroundPipes) {
  const TestPoints pipe = Pipe(1500, 3);
  for (const uint32_t k : {10u, 40u, 300u, 500u}) {
    const EstimationResult result = MustEstimate(pipe.ToCloud(), LinearOptions(k));
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_EQ(point.status, PointStatus::kOk) << k;
      ASSERT_NEAR(point.k1, 0.0, 1e-4) << k;
      ASSERT_NEAR(point.k2, 2.0, 1e-4) << k;
      ASSERT_NEAR(point.gaussian, 0.0, 2e-4) << k;
    }
  }
}

TEST_P(LinearRegressionTest, IsExactOnWholeSpheres) {
  const TestPoints sphere = Sphere(400, 3.0);
  for (const uint32_t k : {10u, 100u, 400u}) {
    const EstimationResult result = MustEstimate(sphere.ToCloud(), LinearOptions(k));
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_EQ(point.status, PointStatus::kOk) << k;
      ASSERT_NEAR(point.k1, 1.0 / 3.0, 1e-5) << k;
      ASSERT_NEAR(point.k2, 1.0 / 3.0, 1e-5) << k;
    }
  }
}

TEST_P(LinearRegressionTest, TakesMoreOfTheNoiseOfPipesAwayThanOtherDegreesDo) {
  TestPoints pipe = Pipe(3000, 3);
  AddNoise(0.01, 0.1, 5, pipe);
  const double error = MeanErrorBeside(MustEstimate(pipe.ToCloud(), LinearOptions(300)), 1.0);
  for (const uint32_t degree : {2u, 3u}) {
    for (const uint32_t k : {16u, 32u, 64u}) {
      EXPECT_LT(error, 0.5 * MeanErrorBeside(MustEstimate(pipe.ToCloud(), LinearOptions(k, degree)), 1.0))
          << degree << ", " << k;
    }
  }
}

TEST_P(LinearRegressionTest, NoiseAlongTheNormalSaysNothingOfPlanes) {
  TestPoints plane = RandomPoints(Layout::kCoplanar, 2000, 5);
  for (auto& normal : plane.normals) normal = {0.0f, 0.0f, 1.0f};
  AddNoise(1e-5, 0.1, 5, plane);
  for (const uint32_t k : {16u, 64u}) {
    const double quadratic = MeanErrorBeside(MustEstimate(plane.ToCloud(), LinearOptions(k, 2)), 0.0);
    EXPECT_LT(MeanErrorBeside(MustEstimate(plane.ToCloud(), LinearOptions(k)), 0.0), 1.2 * quadratic) << k;
  }
}

TEST_P(LinearRegressionTest, PlanesAreFlat) {
  TestPoints plane = RandomPoints(Layout::kCoplanar, 2000, 5);
  for (auto& normal : plane.normals) normal = {0.0f, 0.0f, 1.0f};
  for (const uint32_t k : {6u, 20u, 300u}) {
    const EstimationResult result = MustEstimate(plane.ToCloud(), LinearOptions(k));
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_EQ(point.status, PointStatus::kOk);
      ASSERT_LT(std::abs(point.k1) + std::abs(point.k2), 1e-5 / point.radius);
    }
  }
}

TEST_P(LinearRegressionTest, PointsOnALineShowNoCurvatureAcrossIt) {
  const double root = std::sqrt(0.2);
  TestPoints across, along;
  for (int i = 0; i < 500; ++i) {
    across.Add(0.01 * i, 0.02 * i, 0.0, 0.0, 0.0, 1.0);
    along.Add(0.01 * i, 0.02 * i, 0.0, root, 2.0 * root, 0.0);
  }
  for (const TestPoints* const line : {&across, &along}) {
    const EstimationResult result = MustEstimate(line->ToCloud(), LinearOptions(20));
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_EQ(point.status, PointStatus::kSingularFit);
      ASSERT_TRUE(std::isnan(point.mean));
    }
  }
}

TEST_P(LinearRegressionTest, ANormalAgainstItsSurroundingsIsInconsistent) {
  TestPoints sphere = Sphere(2000, 3.0);
  for (float& component : sphere.normals[7]) component = -component;
  EstimatorOptions options = LinearOptions(50);
  const EstimationResult result = MustEstimate(sphere.ToCloud(), options);
  const PointStatus status = result.field.points[7].status;
  EXPECT_TRUE(status == PointStatus::kInconsistentNormals || status == PointStatus::kOpposedNormals);
  TestPoints random = RandomPoints(Layout::kCoplanar, 2000, 5);
  std::mt19937_64 engine(1);
  std::normal_distribution<float> gaussian;
  for (auto& normal : random.normals) normal = {gaussian(engine), gaussian(engine), gaussian(engine)};
  size_t ok = 0;
  const EstimationResult of_random = MustEstimate(random.ToCloud(), LinearOptions(300));
  for (const PointCurvature& point : of_random.field.points.span()) {
    ok += point.status == PointStatus::kOk ? 1 : 0;
  }
  EXPECT_LT(ok, 1000u) << "half of the normals contradict what little the mean says";
}

}  // namespace
}  // namespace curvd::testing
