#include "core/scale/edges/one_side.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/core/scale/edges/edge_neighbors.h"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

SideLimits Limits(double noise) { return {200, noise, 0.0, 1.0}; }

TEST(OneSideTest, NeighborsAcrossAnEdgeDoNotCount) {
  for (const double curvature : {0.0, 0.5}) {
    for (const double distance : {0.02, 0.2}) {
      const auto point = EstimateOneSide(NeighborsAtEdge(curvature, distance, 0.0), Vector3d::UnitZ(), Limits(0.0));
      ASSERT_TRUE(point.has_value());
      EXPECT_NEAR(point->mean, 0.5 * curvature, 0.01 * curvature + 1e-9) << distance;
      EXPECT_NEAR(point->gaussian, 0.0, 0.01 * curvature + 1e-9);
      EXPECT_NEAR(point->k2, curvature, 0.01 * curvature + 1e-9);
      EXPECT_EQ(point->status, PointStatus::kOk);
      EXPECT_GT(point->radius, 0.5f);
    }
  }
}

TEST(OneSideTest, NoiseOfNormalsIsAveraged) {
  const auto point = EstimateOneSide(NeighborsAtEdge(0.0, 0.1, 0.1), Vector3d::UnitZ(), Limits(0.1));
  ASSERT_TRUE(point.has_value());
  // One neighbor's noise over the radius, less by the root of their number, and some more at a border.
  EXPECT_NEAR(point->mean, 0.0, 0.1);
}

TEST(OneSideTest, TooFewOnTheSideSayNothing) {
  std::vector<NeighborNormal> neighbors = NeighborsAtEdge(0.0, 0.1, 0.0);
  neighbors.resize(7);
  EXPECT_FALSE(EstimateOneSide(neighbors, Vector3d::UnitZ(), Limits(0.0)).has_value());
  EXPECT_FALSE(EstimateOneSide(NeighborsAtEdge(0.0, 0.1, 0.0), -Vector3d::UnitZ(), Limits(0.0)).has_value());
}

}  // namespace
}  // namespace curvd::testing
