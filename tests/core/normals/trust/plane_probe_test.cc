#include "core/normals/trust/plane_probe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "tests/core/normals/trust/probed_clouds.h"

namespace curvd::testing {
namespace {

std::optional<NormalFit> ProbedPlane(const TestPoints& points, uint32_t max_neighbor_count = 10'000,
                                     bool backwards = false) {
  return Probed<PlaneProbe>(points, max_neighbor_count, backwards);
}

TEST(PlaneProbeTest, FindsThePlanesThatNormalsAreThoseOf) {
  for (const double sigma : {0.1, 0.2}) {
    for (const uint32_t count : {12, 20, 29, 40}) {
      const auto found = ProbedPlane(WithFittedNormals(TorusWithNoise(sigma), NormalMethod::kPca, count));
      ASSERT_TRUE(found.has_value()) << sigma << " " << count;
      EXPECT_EQ(found->method, NormalMethod::kPca);
      EXPECT_EQ(ProbedCount(*found), count) << sigma;
      EXPECT_FALSE(found->half.has_value());
    }
  }
}

// As of scans that are much denser than their noise is small.
TEST(PlaneProbeTest, FindsPlanesOfHundredsOfNeighbors) {
  TestPoints sphere = Sphere(8'000, 1.0);
  AddNoise(0.05, 6, sphere);
  const auto found = ProbedPlane(WithFittedNormals(sphere, NormalMethod::kPca, 250));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(ProbedCount(*found), 250u);
}

// Halves of ten neighbors would tell nothing: planes of twelve have about that noise, too. Of fewer, nothing is told.
TEST(PlaneProbeTest, HalvesAreOfEnoughNeighbors) {
  const auto few = ProbedPlane(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kPca, 10));
  ASSERT_TRUE(few.has_value());
  EXPECT_EQ(few->method, NormalMethod::kPca);
  EXPECT_EQ(ProbedCount(*few), 12u);
  EXPECT_FALSE(ProbedPlane(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kPca, 8)).has_value());
}

// Halves of the neighbors share what bends do to planes.
TEST(PlaneProbeTest, PlanesThatErrByBendsAreNotTold) {
  for (const uint32_t count : {30, 100}) {
    EXPECT_FALSE(ProbedPlane(WithFittedNormals(TorusWithNoise(0.003), NormalMethod::kPca, count)).has_value()) << count;
  }
}

// Halves would be made of the exact ones as well.
TEST(PlaneProbeTest, ThoseOfAPartOfTheCloudAreNotTold) {
  const TestPoints exact = TorusWithNoise(0.1);
  TestPoints half = WithFittedNormals(exact, NormalMethod::kPca, 20);
  for (size_t i = 0; i < half.size(); ++i) {
    if (half.positions[i][0] > 0.0f) half.normals[i] = exact.normals[i];
  }
  EXPECT_FALSE(ProbedPlane(half).has_value());
}

// As of programs that take all points within a radius.
TEST(PlaneProbeTest, FindsPlanesOfOneRadius) {
  constexpr double kRadius = 0.8, kArea = 4.0 * std::numbers::pi * std::numbers::pi * 6.0 * 2.0;
  NormalOptions normals = EstimateBy(NormalMethod::kPca, 10);
  normals.neighborhood = NeighborRadius{kRadius};
  const TestPoints torus = WithFittedNormals(TorusWithNoise(0.1), normals);
  const auto found = ProbedPlane(torus);
  ASSERT_TRUE(found.has_value());
  const double expected = static_cast<double>(torus.size()) * std::numbers::pi * kRadius * kRadius / kArea;
  EXPECT_NEAR(ProbedCount(*found), expected, 0.2 * expected);
}

// Such as those of files with few decimals.
TEST(PlaneProbeTest, RoundedNormalsAreKnownAgain) {
  TestPoints torus = WithFittedNormals(TorusWithNoise(0.1), NormalMethod::kPca, 20);
  for (auto& normal : torus.normals) {
    for (float& component : normal) component = std::round(component * 1000.0f) / 1000.0f;
  }
  const auto found = ProbedPlane(torus);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(ProbedCount(*found), 20u);
}

TEST(PlaneProbeTest, NormalsOfJetsAreThoseOfNoPlane) {
  for (const NormalMethod method : {NormalMethod::kJet2, NormalMethod::kJet4}) {
    EXPECT_FALSE(ProbedPlane(WithFittedNormals(TorusWithNoise(0.05), method, 60)).has_value());
  }
}

TEST(PlaneProbeTest, OtherNormalsAreThoseOfNoPlane) {
  for (const ProbedCloud& cloud : CloudsWithOtherNormals()) {
    EXPECT_FALSE(ProbedPlane(cloud.points).has_value()) << cloud.what;
  }
}

TEST(PlaneProbeTest, TinyCloudsAndSmallLimitsTellNothing) {
  const TestPoints tiny = WithFittedNormals(Torus(9, 5), NormalMethod::kPca, 6);
  EXPECT_FALSE(ProbedPlane(tiny).has_value());
  EXPECT_FALSE(ProbedPlane(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kPca, 16), 16).has_value());
}

TEST(PlaneProbeTest, TheOrderOfBlocksChangesNothing) {
  const TestPoints torus = WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kPca, 22);
  const auto forwards = ProbedPlane(torus), backwards = ProbedPlane(torus, 10'000, true);
  ASSERT_TRUE(forwards.has_value() && backwards.has_value());
  EXPECT_EQ(ProbedCount(*forwards), ProbedCount(*backwards));
  EXPECT_EQ(forwards->method, backwards->method);
}

TEST(PlaneProbeTest, EndsWhereItIsStopped) { ExpectEndsWhereStopped<PlaneProbe>(); }

TEST(PlaneProbeTest, PointsThatFixNoPlaneTellNothing) {
  for (const Layout layout : kLayouts) EXPECT_FALSE(ProbedPlane(RandomPoints(layout, 2'000, 3)).has_value());
}

}  // namespace
}  // namespace curvd::testing
