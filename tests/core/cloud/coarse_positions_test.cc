#include "core/cloud/coarse_positions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace curvd::testing {
namespace {

template <typename Scalar>
Cloud CloudOf(const std::vector<Scalar>& positions, std::optional<Lattice> lattice = std::nullopt) {
  Cloud cloud(sizeof(Scalar) == 4 ? ScalarType::kFloat32 : ScalarType::kFloat64, InvalidPointPolicy::kSkip,
              NormalsInput::kAbsent);
  if (lattice.has_value()) cloud.PlaceOn(*lattice);
  const std::string_view bytes(reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(Scalar));
  EXPECT_TRUE(cloud.Append(bytes, {}).ok());
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

// A sphere of radius 1 around (east, north, 0). 10,000 points on it are about 0.02 apart.
template <typename Scalar = float>
std::vector<Scalar> SphereAt(double east, double north, size_t count = 10'000) {
  std::vector<Scalar> positions;
  for (size_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double angle = 2.39996 * static_cast<double>(i), ring = std::sqrt(1.0 - z * z);
    for (const double v : {east + ring * std::cos(angle), north + ring * std::sin(angle), z}) {
      positions.push_back(static_cast<Scalar>(v));
    }
  }
  return positions;
}

TEST(CoarsePositionsTest, GeoreferencedFloatsAreCoarse) {
  const auto coarse = FindCoarsePositions(CloudOf(SphereAt(5e5, 5e6)));
  ASSERT_TRUE(coarse.has_value());
  EXPECT_NEAR(coarse->farthest, 5e6, 1.0);
  EXPECT_EQ(coarse->step, 0.5);
  EXPECT_NEAR(coarse->spacing, 0.02, 0.005);
}

TEST(CoarsePositionsTest, ScansWithoutReturnsAreNoLessCoarse) {
  std::vector<float> positions = SphereAt(5e5, 5e6);
  for (size_t i = 0; i < positions.size(); i += 90) {  // a point in 30
    const float value = i % 180 == 0 ? 0.0f : std::numeric_limits<float>::quiet_NaN();
    for (size_t axis = 0; axis < 3; ++axis) positions[i + axis] = value;
  }
  EXPECT_TRUE(FindCoarsePositions(CloudOf(positions)).has_value());
}

TEST(CoarsePositionsTest, EveryPartOfALargeCloudIsLookedAt) {
  // Of so many points a stride apart, and of the last ones.
  for (const size_t count : {4093u, 4094u, 8191u, 300'001u}) {
    EXPECT_TRUE(FindCoarsePositions(CloudOf(SphereAt(5e5, 5e6, count))).has_value()) << count;
    EXPECT_FALSE(FindCoarsePositions(CloudOf(SphereAt(0.0, 0.0, count))).has_value()) << count;
  }
}

TEST(CoarsePositionsTest, OthersAreNot) {
  EXPECT_FALSE(FindCoarsePositions(CloudOf(SphereAt(0.0, 0.0))).has_value());
  EXPECT_FALSE(FindCoarsePositions(CloudOf(SphereAt(1e3, 1e3))).has_value()) << "floats lie 6e-5 apart";
  EXPECT_FALSE(FindCoarsePositions(CloudOf(SphereAt(5e5, 5e6, 50))).has_value()) << "few points";
  EXPECT_FALSE(FindCoarsePositions(CloudOf(SphereAt<double>(5e5, 5e6))).has_value());
  EXPECT_FALSE(
      FindCoarsePositions(CloudOf(SphereAt(5e5, 5e6), Lattice{.spacing = 0.5, .origin = {5e5, 5e6, 0.0}})).has_value());
  EXPECT_FALSE(FindCoarsePositions(CloudOf(std::vector<float>(3'000, 5e6f))).has_value()) << "one place";
  EXPECT_FALSE(FindCoarsePositions(CloudOf(std::vector<float>())).has_value());
  // A line and a plane along an axis.
  std::vector<float> line, plane;
  for (int i = 0; i < 2'500; ++i) {
    for (const int v : {i, 0, 0}) line.push_back(static_cast<float>(v));
    for (const int v : {i % 50, i / 50, 7}) plane.push_back(static_cast<float>(v));
  }
  EXPECT_FALSE(FindCoarsePositions(CloudOf(line)).has_value());
  EXPECT_FALSE(FindCoarsePositions(CloudOf(plane)).has_value());
}

}  // namespace
}  // namespace curvd::testing
