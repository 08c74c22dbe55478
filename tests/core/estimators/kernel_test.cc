// What all strategies share, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "hwy/highway.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_estimator.h"
#include "tests/core/sanitized.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using KernelTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, KernelTest, InstructionSets(), InstructionSetName);

// The distance of the K-th neighbor as the kernels round it.
float FloatRadius(const TestPoints& points, size_t i, const std::vector<int>& ids) {
  float largest = 0.0f;
  for (int id : ids) {
    float d[3];
    for (int axis = 0; axis < 3; ++axis) d[axis] = points.positions[id][axis] - points.positions[i][axis];
    largest = std::max(largest, (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]);
  }
  return std::sqrt(largest);
}

TEST_P(KernelTest, RadiusIsThatOfTheKthNeighborOnEveryLayout) {
  for (Layout layout : kLayouts) {
    for (uint64_t seed = 0; seed < 4; ++seed) {
      const TestPoints points = RandomPoints(layout, 700 + 37 * seed, seed);
      for (uint32_t k : {4u, 15u, 50u, 300u}) {
        EstimatorOptions options;
        options.neighborhood = NeighborCount{k};
        const EstimationResult result = MustEstimate(points.ToCloud(), options);
        for (size_t i = 0; i < points.size(); i += 13 * kSparser) {
          const PointCurvature& point = result.field.points[i];
          if (point.status != PointStatus::kOk) continue;
          const float expected = FloatRadius(points, i, NearestIds(points, i, k));
          // Two neighbors whose distances agree to float rounding may stand for each other.
          ASSERT_NEAR(point.radius, expected, 1e-6f * expected)
              << LayoutName(layout) << " seed " << seed << " k " << k << " point " << i;
        }
      }
    }
  }
}

TEST_P(KernelTest, InstructionSetsAgreeToFloatRounding) {
  for (std::string_view estimator :
       {"avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso", "normal-regression"}) {
    EstimatorOptions options;
    options.estimator = estimator;
    const TestPoints points = Sphere(3000, 2.0);
    const EstimationResult here = MustEstimate(points.ToCloud(), options);
    hwy::SetSupportedTargetsForTest(0);
    const EstimationResult best = MustEstimate(points.ToCloud(), options);
    hwy::SetSupportedTargetsForTest(GetParam());
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(here.field.points[i].status, best.field.points[i].status);
      // 1e-6 relative; sums of 100 triangles in another order round a little more.
      ASSERT_NEAR(here.field.points[i].mean, best.field.points[i].mean, 2e-6) << "point " << i;
      ASSERT_EQ(here.field.points[i].radius, best.field.points[i].radius) << "point " << i;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
