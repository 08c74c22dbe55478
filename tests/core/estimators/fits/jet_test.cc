// Jets against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

using JetTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, JetTest, InstructionSets(), InstructionSetName);

TEST_P(JetTest, MatchesTheDoubleOracle) {
  for (uint32_t degree : {2u, 3u, 4u}) {
    for (uint32_t k : {25u, 50u, 300u}) {
      EstimatorOptions options;
      options.estimator = "jet";
      options.jet_degree = degree;
      options.neighborhood = NeighborCount{k};
      ExpectNearReference(Sphere(2000, 3.0), options, 11);
      ExpectNearReference(Waves(2000, 0.0, k), options, 11);
      ExpectNearReference(Waves(2000, 0.01, k), options, 11);
    }
  }
}

TEST_P(JetTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options;
  options.estimator = "jet";
  options.neighborhood = NeighborRadius{0.61};
  ExpectNearReference(Sphere(2000, 3.0), options, 11);
}

}  // namespace
}  // namespace curvd::testing
