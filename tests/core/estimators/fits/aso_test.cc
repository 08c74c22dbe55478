// The algebraic shape operator against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

using AsoTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, AsoTest, InstructionSets(), InstructionSetName);

TEST_P(AsoTest, MatchesTheDoubleOracle) {
  for (uint32_t k : {15u, 50u, 300u}) {
    EstimatorOptions options;
    options.estimator = "aso";
    options.neighborhood = NeighborCount{k};
    ExpectNearReference(Sphere(2000, 3.0), options, 11);
    ExpectNearReference(Waves(2000, 0.0, k), options, 11);
    ExpectNearReference(Waves(2000, 0.01, k), options, 11);
  }
}

TEST_P(AsoTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options;
  options.estimator = "aso";
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Sphere(2000, 3.0), options, 11);
}

}  // namespace
}  // namespace curvd::testing
