// The automatic choice beside sharp edges.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// A box of `side` x `side` points a face, a spacing of 1 apart, exact normals.
TestPoints Box(int side) {
  TestPoints box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double end : {0.0, 1.0}) {
      for (int i = 0; i < side * side; ++i) {
        double at[3], normal[3] = {0.0, 0.0, 0.0};
        at[axis] = end * side;
        at[(axis + 1) % 3] = i % side + 0.5;
        at[(axis + 2) % 3] = i / side + 0.5;
        normal[axis] = 2.0 * end - 1.0;
        box.Add(at[0], at[1], at[2], normal[0], normal[1], normal[2]);
      }
    }
  }
  return box;
}

TEST(AutomaticEdgesTest, FacesOfABoxAreFlatUpToTheEdges) {
  TestPoints box = Box(30);
  const EstimationResult exact = MustEstimate(box.ToCloud(), Automatic());
  for (const PointCurvature& point : exact.field.points.span()) {
    ASSERT_EQ(point.status, PointStatus::kOk);
    EXPECT_NEAR(point.mean, 0.0, 0.01);  // avg-hexagram of 16 points errs by some 0.4 beside an edge
  }
  AddNoise(0.05, 3, box);
  EXPECT_LT(MeanError(MustEstimate(box.ToCloud(), Automatic()), 0.0), 0.01) << "a tenth of what avg-hexagram errs by";
}

// Of the curvature itself, which is 0, and what the points say of their estimates.
TEST(AutomaticEdgesTest, ExactFacesWithNoisyNormalsAreFlatUpToTheEdges) {
  TestPoints box = Box(30);
  AddNoise(0.0, 0.1, 3, box);
  const EstimationResult result = MustEstimate(box.ToCloud(), WithChoice(Automatic()));
  size_t jets = 0;
  for (size_t i = 0; i < box.size(); ++i) {
    ASSERT_EQ(result.field.points[i].status, PointStatus::kOk);

    const PointChoice& choice = result.choices[i];
    ASSERT_FALSE(std::isnan(choice.neighbor_count)) << i;
    // The neighborhoods that were chosen reach an edge, and the point has a fit of its own.
    double to_edge = 30.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = box.positions[i][axis];
      if (box.normals[i][axis] * box.normals[i][axis] < 0.5f) to_edge = std::min({to_edge, at, 30.0 - at});
    }
    if (to_edge > 4.0) continue;
    ASSERT_FALSE(std::isnan(choice.mean_error) || std::isnan(choice.k1_error)) << i;
    jets += choice.jet_weight > 0.99f ? 1 : 0;
  }
  EXPECT_LT(MeanError(result, 0.0), 1e-5) << "by the normals it is 0.0007";
  EXPECT_GT(jets, box.size() / 4) << "of those beside an edge";
}

// A hemisphere of radius 6.3 on a plate, a spacing of 1 apart, as chance has it. The hemisphere comes first.
constexpr size_t kDomePoints = 250, kPlatePoints = 3750;
TestPoints DomeOnPlate() {
  constexpr double kRadius = 6.3, kHalfWidth = 31.0;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  TestPoints points;
  while (points.size() < kDomePoints) {
    const double height = unit(random), angle = 2.0 * std::numbers::pi * unit(random);
    const double ring = std::sqrt(1.0 - height * height), x = ring * std::cos(angle), y = ring * std::sin(angle);
    points.Add(kRadius * x, kRadius * y, kRadius * height, x, y, height);
  }
  while (points.size() < kDomePoints + kPlatePoints) {
    const double x = kHalfWidth * (2.0 * unit(random) - 1.0), y = kHalfWidth * (2.0 * unit(random) - 1.0);
    if (std::hypot(x, y) > kRadius) points.Add(x, y, 0.0, 0.0, 0.0, 1.0);
  }
  return points;
}

// All neighborhoods that serve the plate reach across the edge, and on its own side the hemisphere bends.
TEST(AutomaticEdgesTest, ABentFaceBesideAFlatOneKeepsItsCurvature) {
  for (const double noise : {0.0, 0.05}) {
    TestPoints points = DomeOnPlate();
    if (noise > 0.0) AddNoise(noise, 0.4 * noise, 3, points);
    const EstimationResult result = MustEstimate(points.ToCloud(), WithChoice(Automatic()));
    double error = 0.0;
    size_t count = 0, within = 0;
    for (size_t i = 0; i < kDomePoints; ++i) {
      if (points.positions[i][2] < 3.0f) continue;
      ASSERT_EQ(result.field.points[i].status, PointStatus::kOk);
      const double off = std::abs(result.field.points[i].mean - 1.0 / 6.3);
      error += off;
      within += off <= 1.645 * result.choices[i].mean_error ? 1 : 0;
      ++count;
    }
    EXPECT_LT(error / static_cast<double>(count), (noise > 0.0 ? 0.25 : 0.05) / 6.3) << "0.45 and 0.6 of it before";
    EXPECT_GT(within, count * 7 / 10);
  }
}

// Hardly any point has a neighborhood that reaches no edge.
TEST(AutomaticEdgesTest, SmallFacesAreFlatToo) {
  for (const int side : {16, 20}) {
    const EstimationResult result = MustEstimate(Box(side).ToCloud(), Automatic());
    EXPECT_LT(MeanError(result, 0.0), 0.02) << side;
  }
}

}  // namespace
}  // namespace curvd::testing
