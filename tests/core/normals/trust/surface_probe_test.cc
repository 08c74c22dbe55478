#include "core/normals/trust/surface_probe.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>

#include "tests/core/normals/trust/probed_clouds.h"

namespace curvd::testing {
namespace {

std::optional<NormalsOffSurface> NormalsOff(const TestPoints& points, bool backwards = false) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  SurfaceProbe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = false;
  while (probe.AddBlocks()) {
    const size_t count = probe.block_count();
    for (size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(probe.RunBlock(backwards ? count - 1 - i : i, 0, stopped).ok());
    }
  }
  return probe.found();
}

TEST(SurfaceProbeTest, NormalsOfTheSurfaceStandOnIt) {
  for (const double sigma : {0.0, 0.05, 0.1}) {
    const auto found = NormalsOff(TorusWithNoise(sigma));
    ASSERT_TRUE(found.has_value()) << sigma;
    EXPECT_GE(found->sampled_points, 32u) << sigma;
    EXPECT_EQ(found->off_points, 0u) << sigma;
  }
  for (const ProbedCloud& cloud : CloudsWithOtherNormals()) {
    const auto found = NormalsOff(cloud.points);
    EXPECT_LE(found.value_or(NormalsOffSurface()).share(), 0.1) << cloud.what;
  }
}

TEST(SurfaceProbeTest, FindsPositionsThatWereTurnedWithoutTheirNormals) {
  TestPoints torus = TorusWithNoise(0.05);
  for (auto& position : torus.positions) std::swap(position[1], position[2]);
  const auto found = NormalsOff(torus);
  ASSERT_TRUE(found.has_value());
  EXPECT_GT(found->share(), 0.5);
}

// Off all but the caps within 30 degrees of the axis, which have 0.13 of the area.
TEST(SurfaceProbeTest, FindsPlaceholders) {
  TestPoints sphere = Sphere(30'000, 1.0);
  for (auto& normal : sphere.normals) normal = {0.0f, 0.0f, 1.0f};
  const auto found = NormalsOff(sphere);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->share(), 0.87, 0.08);
}

// The nearest ten points lie on one line; planes through them turn around it by chance.
TEST(SurfaceProbeTest, FindsPlanesOfPointsOnOneScanLine) {
  for (const double gap : {8.0, 16.0, 32.0}) {
    const TestPoints saddle = ScannedSaddle(20'000, gap, 0.1, 3);
    const auto planes = NormalsOff(WithFittedNormals(saddle, NormalMethod::kPca, 10));
    ASSERT_TRUE(planes.has_value()) << gap;
    EXPECT_GT(planes->share(), 0.5) << gap;
    const auto right = NormalsOff(saddle);
    ASSERT_TRUE(right.has_value()) << gap;
    EXPECT_EQ(right->off_points, 0u) << gap;
  }
}

// The noise of normals that a person should know of.
TEST(SurfaceProbeTest, NoiseCountsWhereItIsLarge) {
  std::mt19937_64 random(5);
  for (const double sigma : {0.2, 0.6}) {
    std::normal_distribution<float> noise(0.0f, static_cast<float>(sigma));
    TestPoints torus = TorusWithNoise(0.0);
    for (auto& normal : torus.normals) {
      for (float& component : normal) component += noise(random);
    }
    const auto found = NormalsOff(torus);
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->share() > kMostOffSurface, sigma > 0.4) << sigma << ": " << found->share();
  }
}

TEST(SurfaceProbeTest, NothingIsToldOfFewPointsAndOfBodies) {
  EXPECT_FALSE(NormalsOff(Sphere(100, 1.0)).has_value());
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  TestPoints body;
  for (int i = 0; i < 5'000; ++i) body.Add(anywhere(random), anywhere(random), anywhere(random), 0.0, 0.0, 1.0);
  EXPECT_FALSE(NormalsOff(body).has_value());
}

TEST(SurfaceProbeTest, TheOrderOfBlocksDoesNotMatter) {
  const TestPoints planes = WithFittedNormals(ScannedSaddle(20'000, 16.0, 0.1, 3), NormalMethod::kPca, 10);
  const auto forwards = NormalsOff(planes), backwards = NormalsOff(planes, true);
  ASSERT_TRUE(forwards.has_value() && backwards.has_value());
  EXPECT_EQ(forwards->sampled_points, backwards->sampled_points);
  EXPECT_EQ(forwards->off_points, backwards->off_points);
}

TEST(SurfaceProbeTest, EndsWhereStopped) { ExpectEndsWhereStopped<SurfaceProbe>(); }

}  // namespace
}  // namespace curvd::testing
