// The kernels against brute force and the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "hwy/highway.h"
#include "tests/core/expect_curvature.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_estimator.h"
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
        for (size_t i = 0; i < points.size(); i += 13) {
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

void ExpectNearReference(const TestPoints& points, const EstimatorOptions& options, size_t step) {
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  size_t compared = 0;
  for (size_t i = 0; i < points.size(); i += step) {
    const PointCurvature& point = result.field.points[i];
    const ReferenceCurvature reference = ReferenceEstimate(points, i, options);
    if (point.status != PointStatus::kOk || !reference.estimated || reference.margin < 1e-5) continue;
    SCOPED_TRACE(i);
    ExpectNear(point, reference);
    ++compared;
  }
  EXPECT_GT(compared, points.size() / step / 2);
}

TEST_P(KernelTest, AvgHexagramMatchesTheDoubleOracle) {
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

TEST_P(KernelTest, HexagramMatchesTheDoubleOracle) {
  // The largest figures reach around the sphere, far from any point.
  for (uint32_t k : {4u, 15u, 50u, 300u, 1900u}) {
    EstimatorOptions options;
    options.estimator = "hexagram";
    options.neighborhood = NeighborCount{k};
    ExpectNearReference(Sphere(2000, 3.0), options, 11);
    ExpectNearReference(RandomPoints(Layout::kCoplanar, 2000, k), options, 11);
    ExpectNearReference(RandomPoints(Layout::kUniform, 2000, k), options, 11);
  }
}

TEST_P(KernelTest, CornersThatTieGoToTheLowerId) {
  // Two targets of each point that looks up are 1.5 away along y, halfway between two others, maybe of two leaves.
  constexpr int kSide = 45, kCells = kSide * kSide;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> tilt(-0.3, 0.3);
    std::vector<int> cells(kCells);
    std::iota(cells.begin(), cells.end(), 0);
    std::shuffle(cells.begin(), cells.end(), random);
    TestPoints points;
    std::vector<size_t> looking_up;
    for (int cell : cells) {
      const int x = cell % kSide, y = cell / kSide;
      const bool looks_up = x % 3 == 0 && y % 3 == 0;
      if (looks_up && std::min(x, y) > 3 && std::max(x, y) < kSide - 3) looking_up.push_back(points.size());
      const double nx = looks_up ? 0.0 : tilt(random), ny = looks_up ? 0.0 : tilt(random);
      points.Add(2.25 * x, y, 0, nx, ny, std::sqrt(1.0 - nx * nx - ny * ny));
    }
    EstimatorOptions options;
    options.estimator = "hexagram";
    options.neighborhood = NeighborRadius{2.3};
    options.average_normal_weight = 0.0;
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    for (size_t i : looking_up) {
      const ReferenceCurvature reference = ReferenceEstimate(points, i, options);
      ASSERT_EQ(reference.margin, 0.0);
      SCOPED_TRACE(i);
      ExpectNear(result.field.points[i], reference);
    }
  }
}

TEST_P(KernelTest, JetsMatchTheDoubleOracle) {
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

TEST_P(KernelTest, AlgebraicShapeOperatorMatchesTheDoubleOracle) {
  for (uint32_t k : {15u, 50u, 300u}) {
    EstimatorOptions options;
    options.estimator = "aso";
    options.neighborhood = NeighborCount{k};
    ExpectNearReference(Sphere(2000, 3.0), options, 11);
    ExpectNearReference(Waves(2000, 0.0, k), options, 11);
    ExpectNearReference(Waves(2000, 0.01, k), options, 11);
  }
}

TEST_P(KernelTest, RadiusNeighborhoodsMatchTheDoubleOracle) {
  for (std::string_view estimator : {"avg-hexagram", "jet", "aso"}) {
    EstimatorOptions options;
    options.estimator = estimator;
    options.neighborhood = NeighborRadius{0.61};
    ExpectNearReference(Sphere(2000, 3.0), options, 11);
  }
}

TEST_P(KernelTest, InstructionSetsAgreeToFloatRounding) {
  for (std::string_view estimator : {"avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso"}) {
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

TEST_P(KernelTest, TiesGoToTheLowerId) {
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
