// Hexagram against the double oracle, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "tests/core/expect_near_reference.h"
#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

using HexagramTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, HexagramTest, InstructionSets(), InstructionSetName);

TEST_P(HexagramTest, MatchesTheDoubleOracle) {
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

// A ball around a target that reaches to its point holds a cluster of more leaves than are looked at one after the
// other.
TEST_P(HexagramTest, FindsCornersBesideADenseClusterBeyondTheNeighborhood) {
  constexpr size_t kSparse = 150, kDense = 20'000;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> radius(1.0, 2.0), angle(0.0, 6.28), tilt(-0.1, 0.1), near(-1e-2, 1e-2);
  TestPoints points;
  for (size_t i = 0; i < kSparse + kDense; ++i) {
    const double r = radius(random), a = angle(random), nx = tilt(random), ny = tilt(random);
    const bool is_sparse = i < kSparse;
    points.Add(is_sparse ? r * std::cos(a) : near(random), is_sparse ? r * std::sin(a) : near(random),
               0.1 * tilt(random), nx, ny, std::sqrt(1.0 - nx * nx - ny * ny));
  }
  EstimatorOptions options;
  options.estimator = "hexagram";
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  size_t compared = 0;
  for (size_t i = 0; i < kSparse; ++i) {
    const ReferenceCurvature reference = ReferenceEstimate(points, i, options);
    if (!reference.estimated || reference.margin < 1e-5) continue;
    SCOPED_TRACE(i);
    ExpectNear(result.field.points[i], reference);
    ++compared;
  }
  EXPECT_GT(compared, kSparse / 2);
}

TEST_P(HexagramTest, CornersThatTieGoToTheLowerId) {
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

}  // namespace
}  // namespace curvd::testing
