#include "core/scale/detail/interval_climb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

constexpr uint32_t kAnyCount = 16;

// Neighbors of the origin on z = height(x, y), at random on the square of that half width, whose normals have noise.
// `slope_at(x, y)` gives the derivatives of the height. Sorted by distance.
std::vector<NeighborNormal> NeighborsOn(const std::function<double(double x, double y)>& height,
                                        const std::function<Eigen::Vector2d(double x, double y)>& slope_at,
                                        double half_width, double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-half_width, half_width);
  std::normal_distribution<double> normal(0.0, noise);
  std::vector<NeighborNormal> neighbors;
  for (int i = 0; i < 1500; ++i) {
    const double x = coordinate(random), y = coordinate(random);
    const Eigen::Vector2d slope = slope_at(x, y);
    Vector3d direction = Vector3d(-slope.x(), -slope.y(), 1.0).normalized();
    direction += Vector3d(normal(random), normal(random), normal(random));
    neighbors.push_back({{x, y, height(x, y) - height(0.0, 0.0)}, direction.normalized()});
  }
  std::sort(neighbors.begin(), neighbors.end(),
            [](const auto& a, const auto& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); });
  return neighbors;
}

// A bump of height 0.03 and this width on a plane: H at its top is 0.03 / width^2.
std::vector<NeighborNormal> NeighborsOnBump(double width, double noise, unsigned seed) {
  const auto height = [width](double x, double y) { return 0.03 * std::exp(-(x * x + y * y) / (2.0 * width * width)); };
  const auto slope = [=](double x, double y) {
    return Eigen::Vector2d(-x * height(x, y) / (width * width), -y * height(x, y) / (width * width));
  };
  return NeighborsOn(height, slope, 0.4, noise, seed);
}

std::vector<NeighborNormal> NeighborsOnPlane(double noise, unsigned seed) {
  return NeighborsOn([](double, double) { return 0.0; }, [](double, double) { return Eigen::Vector2d::Zero(); }, 0.4,
                     noise, seed);
}

TEST(IntervalClimbTest, NoiseIsNoDetail) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const auto found = EstimateDetail(NeighborsOnPlane(0.05, seed), Vector3d::UnitZ(), kAnyCount, 0.0);
    EXPECT_FALSE(found.has_value()) << seed;
  }
}

TEST(IntervalClimbTest, FindsABumpThatTheMeanHasSmoothedAway) {
  constexpr double kWidth = 0.1, kTruth = 0.03 / (kWidth * kWidth);
  double squares = 0.0, most_deviations = 0.0;
  constexpr int kSeeds = 50;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const auto found = EstimateDetail(NeighborsOnBump(kWidth, 0.03, seed), Vector3d::UnitZ(), kAnyCount, 0.2);
    ASSERT_TRUE(found.has_value()) << seed;
    EXPECT_EQ(found->point.status, PointStatus::kOk);
    // The next larger rung, if not this one, has neighbors far down the slope.
    EXPECT_LE(found->point.radius, 2.0f * static_cast<float>(kWidth)) << seed;
    EXPECT_GE(found->neighbor_count, 32u);
    const double error = found->point.mean - kTruth;
    squares += error * error;
    most_deviations = std::max(most_deviations, std::abs(error) / found->mean_error);
    EXPECT_LE(found->point.k1, found->point.k2);
    EXPECT_TRUE(found->k1_error > 0.0 && found->k2_error > 0.0);
  }
  EXPECT_LT(std::sqrt(squares / kSeeds), 0.15 * kTruth);
  EXPECT_LT(most_deviations, 6.0);
}

TEST(IntervalClimbTest, NoiseOfOneSideIsNoDetail) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::vector<NeighborNormal> neighbors = NeighborsOnPlane(0.02, seed);
    const std::vector<NeighborNormal> noisy = NeighborsOnPlane(0.3, seed);
    for (size_t i = 0; i < neighbors.size(); ++i) {
      if (neighbors[i].offset.x() > 0.05) neighbors[i] = noisy[i];
    }
    EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 0.0).has_value()) << seed;
  }
}

TEST(IntervalClimbTest, LinesOfAScanAreNoDetail) {
  // 10 times as far from each other as their points, along y.
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::vector<NeighborNormal> neighbors = NeighborsOnPlane(0.05, seed);
    for (NeighborNormal& neighbor : neighbors) {
      neighbor.offset.x() = std::round(neighbor.offset.x() / 0.06) * 0.06;
    }
    std::stable_sort(neighbors.begin(), neighbors.end(),
                     [](const auto& a, const auto& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); });
    EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 0.0).has_value()) << seed;
    const auto found = EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 5.0);
    if (found.has_value()) {
      EXPECT_LT(std::abs(found->point.mean), 5.0f) << seed;
    }
  }
}

TEST(IntervalClimbTest, SaysNothingWhereTheMeanIsRight) {
  const std::vector<NeighborNormal> neighbors = NeighborsOnBump(0.1, 0.03, 1);
  const auto found = EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 0.2);
  ASSERT_TRUE(found.has_value());
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, found->point.mean).has_value());
}

TEST(IntervalClimbTest, TakesNoFewerNeighborsThanAllowed) {
  const std::vector<NeighborNormal> neighbors = NeighborsOnBump(0.1, 0.03, 1);
  EXPECT_LT(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 0.2)->neighbor_count, 181u);
  const auto found = EstimateDetail(neighbors, Vector3d::UnitZ(), 181, 0.2);
  EXPECT_TRUE(!found.has_value() || found->neighbor_count >= 181u);
}

TEST(IntervalClimbTest, TooFewNeighborsSayNothing) {
  std::vector<NeighborNormal> neighbors = NeighborsOnBump(0.1, 0.0, 1);
  neighbors.resize(31);
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 100.0).has_value());
  // One rung alone has nothing to be compared with.
  neighbors = NeighborsOnBump(0.1, 0.0, 1);
  neighbors.resize(32);
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 100.0).has_value());
}

TEST(IntervalClimbTest, NeighborsThatDetermineNothingSayNothing) {
  // All at one place; on a line; and with normals that have no mean.
  std::vector<NeighborNormal> neighbors(200, {Vector3d::Zero(), Vector3d::UnitZ()});
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 1.0).has_value());
  for (size_t i = 0; i < neighbors.size(); ++i) neighbors[i].offset.x() = 1e-3 * static_cast<double>(i);
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 1.0).has_value());
  neighbors = NeighborsOnPlane(0.0, 1);
  for (size_t i = 0; i < neighbors.size(); i += 2) neighbors[i].normal = -neighbors[i].normal;
  EXPECT_FALSE(EstimateDetail(neighbors, Vector3d::UnitZ(), kAnyCount, 1.0).has_value());
}

}  // namespace
}  // namespace curvd::testing
