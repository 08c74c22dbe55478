#include "core/scale/edges/normal_trend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "tests/core/scale/edges/edge_neighbors.h"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

std::span<const NeighborNormal> Nearest(const std::vector<NeighborNormal>& all) { return std::span(all).first(32); }

// Neighbors over a disk of this radius, sorted by distance, on waves along x of length 2 pi whose steepest slope is 1.
// The point lies at x = `phase`.
std::vector<NeighborNormal> NeighborsOnWaves(double phase, double radius) {
  std::vector<NeighborNormal> neighbors;
  constexpr double kGoldenAngle = 2.399963;
  for (int i = 0; i < 32; ++i) {
    const double r = radius * std::sqrt(i / 31.0), x = r * std::cos(kGoldenAngle * i);
    const double height = std::sin(phase + x) - std::sin(phase);
    neighbors.push_back(
        {Vector3d(x, r * std::sin(kGoldenAngle * i), height), Vector3d(-std::cos(phase + x), 0.0, 1.0).normalized()});
  }
  return neighbors;
}

TEST(NormalTrendTest, AnEdgeIsRougherThanABend) {
  const std::vector<NeighborNormal> edge = NeighborsAtEdge(0.0, 0.02, 0.0), bend = NeighborsAtEdge(0.5, 10.0, 0.0);
  const NormalTrend at_edge = TrendOf(Nearest(edge)), at_bend = TrendOf(Nearest(bend));
  EXPECT_GT(at_edge.roughness, 0.15);
  EXPECT_LT(at_bend.roughness, 0.01);
  EXPECT_NEAR(at_bend.slope, 0.5, 0.02);
  EXPECT_TRUE(std::isnan(TrendOf({}).roughness));
}

TEST(NormalTrendTest, WavesAsWideAsTheNeighborhoodAreOfBend) {
  for (const double phase : {0.0, 0.8, 1.57, 2.4}) {
    for (const double radius : {1.5, 2.2, 2.9}) {
      const std::vector<NeighborNormal> waves = NeighborsOnWaves(phase, radius);
      EXPECT_GT(TrendOf(waves).roughness, 0.02);
      EXPECT_TRUE(AreOfBend(waves)) << "phase " << phase << " radius " << radius;
    }
  }
}

TEST(NormalTrendTest, EdgesAreOfNoBend) {
  for (const double distance : {0.0, 0.02, 0.05}) {
    for (const double noise : {0.0, 0.1, 0.3}) {
      const std::vector<NeighborNormal> edge = NeighborsAtEdge(0.5, distance, noise);
      EXPECT_FALSE(AreOfBend(Nearest(edge))) << "distance " << distance << " noise " << noise;
    }
  }
}

TEST(NormalTrendTest, TooFewNeighborsAreOfNoBend) {
  const std::vector<NeighborNormal> waves = NeighborsOnWaves(0.8, 2.2);
  EXPECT_FALSE(AreOfBend(std::span(waves).first(15)));
  EXPECT_FALSE(AreOfBend({}));
}

}  // namespace
}  // namespace curvd::testing
