// Uniform triangles against all triangles of a neighborhood, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/expect_curvature.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_estimator.h"
#include "tests/core/reference_triangles.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using UniformTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, UniformTest, InstructionSets(), InstructionSetName);

TEST_P(UniformTest, ManyTrianglesSayWhatAllTrianglesOfTheNeighborhoodSay) {
  const TestPoints points = Waves(600, 0.01, 3);
  EstimatorOptions options;
  options.estimator = "uniform";
  options.triangle_count = 10'000;
  for (const uint32_t k : {4u, 9u}) {
    options.neighborhood = NeighborCount{k};
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    for (size_t i = 0; i < points.size(); i += 29) {
      const PointCurvature& point = result.field.points[i];
      if (point.status != PointStatus::kOk) continue;
      const std::vector<int> ids = NearestIds(points, i, k);
      const ReferenceCurvature all = ReferenceTriangles(points, i, ids, AllTriangles(ids), options);
      // Means of 10,000 draws are off by about a hundredth of what one draw is off.
      const double scale = std::max({std::abs(all.k1), std::abs(all.k2), 1.0 / all.radius});
      EXPECT_NEAR(point.mean, all.mean, 0.05 * scale) << "k " << k << " point " << i;
      EXPECT_NEAR(point.k1, all.k1, 0.1 * scale) << "k " << k << " point " << i;
      EXPECT_NEAR(point.k2, all.k2, 0.1 * scale) << "k " << k << " point " << i;
    }
  }
}

TEST_P(UniformTest, OneTriangleIsOneOfTheNeighborhoods) {
  const TestPoints points = Sphere(500, 2.0);
  EstimatorOptions options;
  options.estimator = "uniform";
  options.triangle_count = 1;
  options.neighborhood = NeighborCount{5};
  for (options.seed = 0; options.seed < 5; ++options.seed) {
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    for (size_t i = 0; i < points.size(); i += 7) {
      const PointCurvature& point = result.field.points[i];
      if (point.status != PointStatus::kOk) continue;
      const std::vector<int> ids = NearestIds(points, i, 5);
      const std::vector<IdTriangle> all = AllTriangles(ids);
      EXPECT_TRUE(
          std::any_of(all.begin(), all.end(),
                      [&](const IdTriangle& triangle) {
                        const ReferenceCurvature one = ReferenceTriangles(points, i, ids, {&triangle, 1}, options);
                        return std::abs(point.mean - one.mean) < 1e-4 && std::abs(point.gaussian - one.gaussian) < 1e-3;
                      }))
          << "seed " << options.seed << " point " << i;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
