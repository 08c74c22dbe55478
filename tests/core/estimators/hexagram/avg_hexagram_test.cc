// Avg-hexagram against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

using AvgHexagramTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, AvgHexagramTest, InstructionSets(), InstructionSetName);

TEST_P(AvgHexagramTest, MatchesTheDoubleOracle) {
  for (uint32_t rotations : {1u, 2u, 3u, 4u}) {
    for (uint32_t k : {15u, 50u, 300u}) {
      EstimatorOptions options;
      options.neighborhood = NeighborCount{k};
      options.rotation_count = rotations;
      ExpectNearReference(Sphere(2000, 3.0), options, 11);
      ExpectNearReference(RandomPoints(Layout::kCoplanar, 2000, k), options, 11);
    }
  }
}

TEST_P(AvgHexagramTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options;
  options.estimator = "avg-hexagram";
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Sphere(2000, 3.0), options, 11);
}

TEST_P(AvgHexagramTest, NeighborsThatTieGoToTheLowerId) {
  // The only tilted normal sits among the lattice points at the K-th distance: it counts for the lower id alone.
  TestPoints points;
  for (int y = -3; y <= 3; ++y) {
    for (int x = -3; x <= 3; ++x) points.Add(x, y, 0, 0, 0, 1);
  }
  const size_t center = 24;
  const auto mean_with_tilt_at = [&](size_t tilted) {
    TestPoints copy = points;
    copy.normals[tilted] = {0.6f, 0.0f, 0.8f};
    EstimatorOptions options;
    options.neighborhood = NeighborCount{7};  // the center, its four neighbors, two of the four diagonals
    return MustEstimate(copy.ToCloud(), options).field.points[center].mean;
  };
  EXPECT_NE(mean_with_tilt_at(16), 0.0f);  // (-1, -1): the lowest ids of the diagonals
  EXPECT_NE(mean_with_tilt_at(18), 0.0f);
  EXPECT_EQ(mean_with_tilt_at(30), 0.0f);  // (-1, 1), (1, 1): left out
  EXPECT_EQ(mean_with_tilt_at(32), 0.0f);
}

}  // namespace
}  // namespace curvd::testing
