#include "core/scale/edges/one_side.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/scale/edges/edge_neighbors.h"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

SideLimits Limits(double noise) { return {200, noise, 0.0, 1.0, 16}; }

TEST(OneSideTest, NeighborsAcrossAnEdgeDoNotCount) {
  for (const double curvature : {0.0, 0.5}) {
    for (const double distance : {0.02, 0.2}) {
      const auto found = EstimateOneSide(NeighborsAtEdge(curvature, distance, 0.0), Vector3d::UnitZ(), Limits(0.0));
      ASSERT_TRUE(found.has_value());
      EXPECT_NEAR(found->point.mean, 0.5 * curvature, 0.01 * curvature + 1e-9) << distance;
      EXPECT_NEAR(found->point.gaussian, 0.0, 0.01 * curvature + 1e-9);
      EXPECT_NEAR(found->point.k2, curvature, 0.01 * curvature + 1e-9);
      EXPECT_EQ(found->point.status, PointStatus::kOk);
      EXPECT_GT(found->point.radius, 0.1f);
      EXPECT_LE(std::abs(found->point.mean - 0.5 * curvature), 3.0 * found->mean_error + 1e-9);
    }
  }
}

// The neighbors at an edge, with this standard deviation in their positions along each axis.
std::vector<NeighborNormal> WithNoise(std::vector<NeighborNormal> neighbors, double noise) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, noise);
  for (NeighborNormal& neighbor : neighbors)
    neighbor.offset += Vector3d(normal(random), normal(random), normal(random));
  std::sort(neighbors.begin(), neighbors.end(),
            [](const auto& a, const auto& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); });
  return neighbors;
}

TEST(OneSideTest, NoiseOfNormalsIsAveraged) {
  SideLimits limits = Limits(0.1);
  limits.height_noise = 0.05;
  const auto found = EstimateOneSide(WithNoise(NeighborsAtEdge(0.0, 0.1, 0.1), 0.05), Vector3d::UnitZ(), limits);
  ASSERT_TRUE(found.has_value());
  EXPECT_FALSE(found->is_by_heights);
  // One neighbor's noise over the radius, less by the root of their number, and some more at a border.
  EXPECT_NEAR(found->point.mean, 0.0, 0.1);
  EXPECT_GT(found->neighbor_count, 100u);
  EXPECT_LT(std::abs(found->point.mean), 3.0 * found->mean_error);
}

TEST(OneSideTest, ExactPositionsCountMoreThanNoisyNormals) {
  const auto found = EstimateOneSide(NeighborsAtEdge(0.5, 0.1, 0.1), Vector3d::UnitZ(), Limits(0.1));
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(found->is_by_heights);
  EXPECT_NEAR(found->point.mean, 0.25, 0.01) << "the normals tell it to a tenth";
  EXPECT_LT(found->mean_error, 0.01);
  EXPECT_NEAR(found->k1_error, std::sqrt(2.0) * found->mean_error, 1e-9);
  EXPECT_EQ(found->k2_error, found->k1_error);
}

TEST(OneSideTest, TooFewOnTheSideSayNothing) {
  std::vector<NeighborNormal> neighbors = NeighborsAtEdge(0.0, 0.1, 0.0);
  neighbors.resize(7);
  EXPECT_FALSE(EstimateOneSide(neighbors, Vector3d::UnitZ(), Limits(0.0)).has_value());
  EXPECT_FALSE(EstimateOneSide(NeighborsAtEdge(0.0, 0.1, 0.0), -Vector3d::UnitZ(), Limits(0.0)).has_value());
}

}  // namespace
}  // namespace curvd::testing
