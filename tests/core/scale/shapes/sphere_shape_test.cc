#include "core/scale/shapes/sphere_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/core/true_clouds.h"

namespace curvd::testing {
namespace {

// Points on a sphere of radius 0.8 that touches the origin, up to 0.6 to the side.
std::vector<PilotNeighbor> Cap(size_t count, double noise = 0.0) {
  constexpr double kRadius = 0.8;
  std::mt19937_64 random(count);
  std::uniform_real_distribution<double> side(-0.6, 0.6);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  std::vector<PilotNeighbor> neighbors;
  while (neighbors.size() < count) {
    const double x = side(random), y = side(random);
    if (x * x + y * y > 0.36) continue;
    const double z = std::sqrt(kRadius * kRadius - x * x - y * y), off = noise * gaussian(random);
    const double t = 1.0 + off / kRadius;
    neighbors.push_back({{t * x, t * y, t * z - kRadius}, {x / kRadius, y / kRadius, z / kRadius}});
  }
  return neighbors;
}

SphereMoments MomentsOf(const std::vector<PilotNeighbor>& neighbors) {
  SphereMoments moments;
  PilotBatch batch;
  for (const PilotNeighbor& neighbor : neighbors) {
    batch.Add(neighbor);
    if (!batch.is_full()) continue;
    moments.Add(batch);
    batch.count = 0;
  }
  moments.Add(batch);
  return moments;
}

TEST(SphereShapeTest, IsExactOnSpheres) {
  const auto shape = SphereShapeOf(MomentsOf(Cap(300)), {}, 300, 0.8);
  ASSERT_TRUE(shape.has_value());
  EXPECT_NEAR(shape->mean, 1.25, 1e-9);
  EXPECT_NEAR(shape->difference, 0.0, 1e-9);
  EXPECT_NEAR(shape->twist, 0.0, 1e-9);
}

TEST(SphereShapeTest, MomentsAreThoseOfPartsAddedUp) {
  const std::vector<PilotNeighbor> all = Cap(300);
  SphereMoments parts = MomentsOf({all.begin(), all.begin() + 101});
  parts += MomentsOf({all.begin() + 101, all.end()});
  const auto whole = SphereShapeOf(MomentsOf(all), {}, 300, 0.8), of_parts = SphereShapeOf(parts, {}, 300, 0.8);
  ASSERT_TRUE(whole.has_value() && of_parts.has_value());
  EXPECT_NEAR(whole->mean, of_parts->mean, 1e-12);
}

// The estimator and the sampled point's shape are the same numbers, the neighbor at the rim included.
TEST(SphereShapeTest, IsWhatTheEstimatorEstimates) {
  constexpr uint32_t kCount = 60;
  std::vector<PilotNeighbor> cap = Cap(kCount - 1, 0.02);
  cap.push_back({{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}});
  TestPoints points;
  double radius = 0.0;
  size_t farthest = 0;
  for (size_t i = 0; i < cap.size(); ++i) {
    const auto& q = cap[i].offset;
    // As float32 has them.
    for (double& coordinate : cap[i].offset) coordinate = static_cast<float>(coordinate);
    points.Add(q[0], q[1], q[2], cap[i].normal[0], cap[i].normal[1], cap[i].normal[2]);
    const double distance = std::hypot(q[0], q[1], q[2]);
    if (distance > radius) farthest = i, radius = distance;
  }
  const auto shape = SphereShapeOf(MomentsOf(cap), {&cap[farthest], 1}, kCount, radius);
  ASSERT_TRUE(shape.has_value());
  const EstimationResult result =
      MustEstimate(points.ToCloud(), {.estimator = "aso", .neighborhood = NeighborCount{kCount}, .project = true});
  const PointCurvature& found = result.field.points[kCount - 1];
  ASSERT_EQ(found.status, PointStatus::kOk);
  EXPECT_NEAR(shape->mean, found.mean, 2e-5);
  EXPECT_NEAR(std::hypot(shape->difference, shape->twist), 0.5 * (found.k2 - found.k1), 2e-5);
}

TEST(SphereShapeTest, ThereIsNoneOfFewOrOfOnePlaceOrUpsideDown) {
  EXPECT_FALSE(SphereShapeOf(SphereMoments(), {}, 0.0, 1.0).has_value());
  EXPECT_FALSE(SphereShapeOf(MomentsOf(Cap(7)), {}, 7.0, 0.8).has_value());
  EXPECT_FALSE(SphereShapeOf(MomentsOf(Cap(20)), {}, 7.0, 0.8).has_value()) << "13 of 20 are copies";
  const std::vector<PilotNeighbor> one_place(20, {{0.1, 0.0, 0.0}, {0.0, 0.0, 1.0}});
  EXPECT_FALSE(SphereShapeOf(MomentsOf(one_place), {}, 20.0, 0.8).has_value());
  std::vector<PilotNeighbor> down = Cap(40);
  for (PilotNeighbor& neighbor : down) {
    for (double& component : neighbor.normal) component = -component;
  }
  EXPECT_FALSE(SphereShapeOf(MomentsOf(down), {}, 40.0, 0.8).has_value());
}

}  // namespace
}  // namespace curvd::testing
