// Delaunay against umbrellas by brute force, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/expect_curvature.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_delaunay.h"
#include "tests/core/sanitized.h"
#include "tests/core/test_clouds.h"
#include "tests/core/umbrella_clouds.h"

namespace curvd::testing {
namespace {

using DelaunayTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, DelaunayTest, InstructionSets(), InstructionSetName);

std::vector<ReferenceUmbrella> BruteForceUmbrellas(const TestPoints& points) {
  std::vector<ReferenceUmbrella> umbrellas;
  for (size_t i = 0; i < points.size(); ++i) umbrellas.push_back(BruteForceUmbrella(points, i));
  return umbrellas;
}

void ExpectEstimatesNearReference(const TestPoints& points, const std::vector<ReferenceUmbrella>& umbrellas,
                                  const EstimatorOptions& options, size_t least_compared) {
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  size_t compared = 0;
  for (size_t i = 0; i < points.size(); i += 7) {
    const PointCurvature& point = result.field.points[i];
    if (point.status != PointStatus::kOk) continue;
    const ReferenceCurvature reference = ReferenceDelaunay(points, umbrellas, i, options);
    if (!reference.estimated || reference.margin == 0.0) continue;
    SCOPED_TRACE(i);
    ExpectNear(point, reference);
    ++compared;
  }
  EXPECT_GE(compared, least_compared);
}

EstimatorOptions Delaunay(uint32_t k, bool even_weights = false) {
  EstimatorOptions options;
  options.estimator = "delaunay";
  options.neighborhood = NeighborCount{k};
  options.even_weights = even_weights;
  return options;
}

TEST_P(DelaunayTest, MatchesTheDoubleOracle) {
  for (uint64_t seed = 0; seed < (kSanitized ? 1 : 2); ++seed) {
    for (const auto& [name, points] : UmbrellaClouds(seed)) {
      SCOPED_TRACE(name);
      const std::vector<ReferenceUmbrella> umbrellas = BruteForceUmbrellas(points);
      const bool surface = name == "patch" || name == "tilted lattice" || name == "sphere";
      for (uint32_t k : {4u, 15u, 50u, 200u}) {
        if (k > points.size()) continue;
        for (bool even : {false, true})
          ExpectEstimatesNearReference(points, umbrellas, Delaunay(k, even), surface ? 40 : 0);
      }
    }
  }
}

TEST_P(DelaunayTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  EstimatorOptions options = Delaunay(50);
  options.neighborhood = NeighborRadius{0.7};
  const TestPoints sphere = Sphere(900, 2.0);
  ExpectEstimatesNearReference(sphere, BruteForceUmbrellas(sphere), options, 100);
}

TEST(DelaunayBesideClusterTest, PointsBesideADenseClusterAreEstimated) {
  // A group that holds points of both would have to list thousands of leaves; its queries go down the tree one by one.
  TestPoints points;
  for (int i = 0; i < 40'010; ++i) points.Add(1e-3 * std::cos(0.001 * i), 1e-3 * std::sin(0.001 * i), 0, 0, 0, 1);
  const size_t first = points.size();
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) points.Add(20 + row, column, 0, 0, 0, 1);
  }
  const EstimationResult result = MustEstimate(points.ToCloud(), Delaunay(9));
  for (size_t i = first; i < points.size(); ++i) {
    ASSERT_EQ(result.field.points[i].status, PointStatus::kOk) << i;
    ASSERT_EQ(result.field.points[i].mean, 0.0f);
  }
}

}  // namespace
}  // namespace curvd::testing
