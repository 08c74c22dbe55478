// The algebraic shape operator against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/true_clouds.h"

namespace curvd::testing {
namespace {

using AsoTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, AsoTest, InstructionSets(), InstructionSetName);

TEST_P(AsoTest, MatchesTheDoubleOracle) {
  for (uint32_t k : {15u, 50u, 300u}) {
    for (const bool project : {false, true}) {
      EstimatorOptions options;
      options.estimator = "aso";
      options.project = project;
      options.neighborhood = NeighborCount{k};
      ExpectNearReference(Sphere(2000, 3.0), options, 11);
      ExpectNearReference(Waves(2000, 0.0, k), options, 11);
      ExpectNearReference(Waves(2000, 0.01, k), options, 11);
    }
  }
}

TEST_P(AsoTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options;
  options.estimator = "aso";
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Sphere(2000, 3.0), options, 11);
}

EstimatorOptions Projecting(bool project, uint32_t count) {
  return {.estimator = "aso", .neighborhood = NeighborCount{count}, .project = project};
}

// The level through a point that lies off the sphere is another sphere about the same center.
TEST(AsoProjectTest, EstimatesTheSphereBesideThePoint) {
  constexpr double kRadius = 2.0;
  for (const double off : {-0.1, 0.0, 0.2}) {
    TestPoints points = Sphere(2000, kRadius);
    for (float& coordinate : points.positions[7]) coordinate *= static_cast<float>((kRadius + off) / kRadius);
    for (const bool project : {false, true}) {
      const EstimationResult result = MustEstimate(points.ToCloud(), Projecting(project, 200));
      EXPECT_NEAR(result.field.points[7].mean, 1.0 / (project ? kRadius : kRadius + off), 0.01) << off;
    }
  }
}

TEST(AsoProjectTest, PointsFarFromTheSurfaceAreRefused) {
  TestPoints points = Sphere(2000, 0.1);
  for (float& coordinate : points.positions[7]) coordinate *= 3.0f;
  const auto status = [&points](bool project) {
    return MustEstimate(points.ToCloud(), Projecting(project, 1000)).field.points[7].status;
  };
  EXPECT_EQ(status(false), PointStatus::kOk);
  EXPECT_EQ(status(true), PointStatus::kSingularFit);
}

// Noise of a point's own position moves its level more than what hundreds of neighbors leave of theirs.
TEST(AsoProjectTest, ErrsMuchLessOnNoisyPositions) {
  TruePoints torus = TrueTorus(8000, 1);
  AddNoise(0.03, 2, torus.points);
  const auto errors = [&torus](bool project) {
    return ErrorsOf(torus, MustEstimate(torus.points.ToCloud(), Projecting(project, 512)).field.points.span());
  };
  const MeanErrors without = errors(false), with = errors(true);
  EXPECT_LT(with.mean, 0.6 * without.mean);
  EXPECT_LT(with.gaussian, without.gaussian);
}

}  // namespace
}  // namespace curvd::testing
