// Independent triangles against every way to part a neighborhood, on each instruction set that this machine has.
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

using IndependentTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, IndependentTest, InstructionSets(), InstructionSetName);

bool SaysTheSame(const PointCurvature& point, const ReferenceCurvature& reference) {
  const double scale = std::max({std::abs(reference.k1), std::abs(reference.k2), 1e-2 / reference.radius});
  return std::abs(point.mean - reference.mean) < 1e-4 * scale && std::abs(point.k1 - reference.k1) < 1e-3 * scale &&
         std::abs(point.k2 - reference.k2) < 1e-3 * scale;
}

// The ways to make two triangles of six points: the first point and two others against the rest.
std::vector<std::vector<IdTriangle>> Partings(const std::vector<int>& ids) {
  std::vector<std::vector<IdTriangle>> partings;
  for (size_t b = 1; b < 6; ++b) {
    for (size_t c = b + 1; c < 6; ++c) {
      std::vector<int> rest;
      for (size_t other = 1; other < 6; ++other) {
        if (other != b && other != c) rest.push_back(ids[other]);
      }
      partings.push_back({{ids[0], ids[b], ids[c]}, {rest[0], rest[1], rest[2]}});
    }
  }
  return partings;
}

TEST_P(IndependentTest, SixNeighborsArePartedIntoTwoTriangles) {
  const TestPoints points = Waves(600, 0.01, 5);
  EstimatorOptions options;
  options.estimator = "independent";
  options.neighborhood = NeighborCount{6};
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  size_t compared = 0;
  for (size_t i = 0; i < points.size(); i += 7) {
    const PointCurvature& point = result.field.points[i];
    if (point.status != PointStatus::kOk) continue;
    const std::vector<int> ids = NearestIds(points, i, 6);
    const std::vector<std::vector<IdTriangle>> partings = Partings(ids);
    EXPECT_TRUE(std::any_of(partings.begin(), partings.end(), [&](const std::vector<IdTriangle>& parting) {
      return SaysTheSame(point, ReferenceTriangles(points, i, ids, parting, options));
    })) << i;
    ++compared;
  }
  EXPECT_GT(compared, 40u);
}

TEST_P(IndependentTest, TriangleCountIsAnUpperBound) {
  const TestPoints points = Waves(600, 0.01, 6);
  EstimatorOptions options;
  options.estimator = "independent";
  options.neighborhood = NeighborCount{6};
  options.triangle_count = 1;
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  for (size_t i = 0; i < points.size(); i += 7) {
    const PointCurvature& point = result.field.points[i];
    if (point.status != PointStatus::kOk) continue;
    const std::vector<int> ids = NearestIds(points, i, 6);
    const std::vector<IdTriangle> all = AllTriangles(ids);
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const IdTriangle& triangle) {
      return SaysTheSame(point, ReferenceTriangles(points, i, ids, {&triangle, 1}, options));
    })) << i;
  }
}

}  // namespace
}  // namespace curvd::testing
