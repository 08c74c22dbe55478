// The local regression of normals against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace curvd::testing
