// Detail where nothing tells the noise: neighbors whose normals are all alike.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "Eigen/Geometry"
#include "core/scale/detail/interval_climb.h"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

// On a spiral of 256 points that fills a disc of radius 0.1.
std::vector<NeighborNormal> NeighborsOnExactPlane(const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<NeighborNormal> neighbors;
  for (int i = 0; i < 256; ++i) {
    const double r = 0.1 * std::sqrt((i + 0.5) / 256.0), turn = 2.4 * i;
    neighbors.push_back({r * std::cos(turn) * u + r * std::sin(turn) * v, normal});
  }
  return neighbors;
}

TEST(ExactPlaneTest, ErrorsAreNoneOrNextToIt) {
  for (const Vector3d& normal : {Vector3d(0.0, 0.0, 1.0), Vector3d(0.6, 0.0, 0.8)}) {
    const auto found = EstimateDetail(NeighborsOnExactPlane(normal), normal, 16, std::nullopt);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->point.mean, 0.0, 1e-6);
    // Sums of products of doubles round to about 1e-8 of a residual.
    constexpr double kMost = 1e-5;
    EXPECT_TRUE(found->mean_error >= 0.0 && found->mean_error < kMost) << found->mean_error;
    EXPECT_TRUE(found->k1_error >= 0.0 && found->k1_error < kMost) << found->k1_error;
    EXPECT_TRUE(found->k2_error >= 0.0 && found->k2_error < kMost) << found->k2_error;
  }
}

// The plane is certain: what is known so far must be wrong.
TEST(ExactPlaneTest, TakesThePlaceOfAnotherMean) {
  const auto found = EstimateDetail(NeighborsOnExactPlane(Vector3d::UnitZ()), Vector3d::UnitZ(), 16, 1.0);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->point.mean, 0.0, 1e-6);
}

}  // namespace
}  // namespace curvd::testing
