#include "core/scale/edges/one_side.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

// Neighbors of a point that is `distance` from an edge: it lies on a cylinder of this curvature along y, which ends
// there; a plane goes on at a right angle. Sorted by distance.
std::vector<SideNeighbor> Edge(double curvature, double distance, double noise) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1.0);
  std::vector<SideNeighbor> neighbors;
  neighbors.push_back({Vector3d::Zero(), Vector3d::UnitZ()});
  const auto add = [&](const Vector3d& offset, Vector3d direction) {
    if (noise > 0.0) direction += Vector3d(normal(random), normal(random), normal(random));
    neighbors.push_back({offset, direction.normalized()});
  };
  for (int i = 0; i < 400; ++i) {
    const double x = coordinate(random), y = coordinate(random), s = std::sin(curvature * y);
    const double bend = curvature > 0.0 ? (std::cos(curvature * y) - 1.0) / curvature : 0.0;
    if (x < distance) {
      add({x, curvature > 0.0 ? s / curvature : y, bend}, {0.0, s, std::cos(curvature * y)});
    } else {
      add({distance, y, bend - (x - distance)}, {1.0, 0.0, 0.0});
    }
  }
  std::sort(neighbors.begin(), neighbors.end(),
            [](const auto& a, const auto& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); });
  return neighbors;
}

SideLimits Limits(double noise) { return {200, noise, 0.0, 1.0}; }

TEST(OneSideTest, NeighborsAcrossAnEdgeDoNotCount) {
  for (const double curvature : {0.0, 0.5}) {
    for (const double distance : {0.02, 0.2}) {
      const auto point = EstimateOneSide(Edge(curvature, distance, 0.0), Vector3d::UnitZ(), Limits(0.0));
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
  const auto point = EstimateOneSide(Edge(0.0, 0.1, 0.1), Vector3d::UnitZ(), Limits(0.1));
  ASSERT_TRUE(point.has_value());
  // One neighbor's noise over the radius, less by the root of their number, and some more at a border.
  EXPECT_NEAR(point->mean, 0.0, 0.1);
}

TEST(OneSideTest, TooFewOnTheSideSayNothing) {
  std::vector<SideNeighbor> neighbors = Edge(0.0, 0.1, 0.0);
  neighbors.resize(7);
  EXPECT_FALSE(EstimateOneSide(neighbors, Vector3d::UnitZ(), Limits(0.0)).has_value());
  EXPECT_FALSE(EstimateOneSide(Edge(0.0, 0.1, 0.0), -Vector3d::UnitZ(), Limits(0.0)).has_value());
}

TEST(NormalTrendTest, TellsAnEdgeFromABend) {
  const auto nearest = [](const std::vector<SideNeighbor>& all) { return std::span(all).first(32); };
  const std::vector<SideNeighbor> edge = Edge(0.0, 0.02, 0.0), bend = Edge(0.5, 10.0, 0.0);
  const NormalTrend at_edge = TrendOf(nearest(edge)), at_bend = TrendOf(nearest(bend));
  EXPECT_GT(at_edge.roughness, 0.15);
  EXPECT_LT(at_bend.roughness, 0.01);
  EXPECT_NEAR(at_bend.slope, 0.5, 0.02);
  EXPECT_TRUE(std::isnan(TrendOf({}).roughness));
}

}  // namespace
}  // namespace curvd::testing
