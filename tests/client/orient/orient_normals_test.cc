#include "client/orient/orient_normals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/surfaces/noise.h"
#include "client/surfaces/random.h"
#include "client/surfaces/surface.h"

namespace curv {
namespace {

std::vector<Vec3> ExactNormals(const Surface& surface, const std::vector<Vec3>& positions) {
  std::vector<Vec3> normals;
  for (const Vec3& p : positions) normals.push_back(surface.At(p).normal);
  return normals;
}

// The share of normals on the outer side after half of them, chosen at random, were negated and then oriented.
double OutwardShare(const std::vector<Vec3>& positions, std::vector<Vec3> normals) {
  const std::vector<Vec3> exact = normals;
  const CounterRandom random(3, 0);
  for (size_t i = 0; i < normals.size(); ++i) {
    if (random.Uniform(i) < 0.5) normals[i] = -2.0 * normals[i];
  }
  const Orientation orientation = OrientNormals(positions, normals);
  double outward = 0;
  for (size_t i = 0; i < normals.size(); ++i) {
    const Vec3 oriented = orientation.flip[i] != 0 ? -normals[i] : normals[i];
    outward += Dot(oriented, exact[i]) > 0 ? 1 : 0;
  }
  return outward / static_cast<double>(normals.size());
}

TEST(OrientNormalsTest, ClosedSurfacesPointOutward) {
  for (const char* name : {"sphere", "torus", "goursat", "ellipsoid"}) {
    const auto surface = *MakeSurface(name);
    const std::vector<Vec3> positions = *SampleEvenly(*surface, 3000, 0);
    EXPECT_EQ(OutwardShare(positions, ExactNormals(*surface, positions)), 1.0) << name;
  }
}

TEST(OrientNormalsTest, NoiseIsNoHindrance) {
  const auto goursat = *MakeSurface("goursat");
  std::vector<Vec3> positions = *SampleEvenly(*goursat, 100'000, 0);
  std::vector<Vec3> normals = ExactNormals(*goursat, positions);
  AddPositionNoise(0.1, 0, positions);
  AddNormalNoise(0.1, 0, normals);
  // The noise is most of the spacing: few points may lie where their neighbors say nothing.
  EXPECT_GT(OutwardShare(positions, normals), 0.9995);
}

// A lens whose rim is bent far more than the points could show: only the mirrored normal leads around it.
TEST(OrientNormalsTest, KnifeEdgesAreNoHindrance) {
  const auto ellipsoid = *MakeSurface("ellipsoid");
  std::vector<Vec3> positions = *SampleEvenly(*ellipsoid, 20'000, 0);
  std::vector<Vec3> normals = ExactNormals(*ellipsoid, positions);
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i].z *= 0.1;
    normals[i] = Normalized({normals[i].x, normals[i].y, 10.0 * normals[i].z});
  }
  // At the rim itself, single points may lie on the wrong side.
  EXPECT_GT(OutwardShare(positions, normals), 0.999);
}

TEST(OrientNormalsTest, OpenSurfacesKeepTheSideOfTheMajority) {
  const auto saddle = *MakeSurface("saddle");
  const std::vector<Vec3> positions = *SampleEvenly(*saddle, 2000, 0);
  std::vector<Vec3> normals = ExactNormals(*saddle, positions);
  for (size_t i = 0; i < normals.size(); ++i) {
    if (i % 3 != 0) normals[i] = -normals[i];
  }
  const Orientation orientation = OrientNormals(positions, normals);
  EXPECT_EQ(orientation.pieces, 1u);
  for (size_t i = 0; i < normals.size(); ++i) EXPECT_EQ(orientation.flip[i] != 0, i % 3 == 0);
}

TEST(OrientNormalsTest, PiecesAreOrientedEachForItself) {
  const auto sphere = *MakeSurface("sphere");
  std::vector<Vec3> positions = *SampleEvenly(*sphere, 500, 0);
  std::vector<Vec3> normals = positions;
  for (size_t i = 0; i < 500; ++i) {
    positions.push_back(positions[i] + Vec3{100, 0, 0});
    normals.push_back(-normals[i]);
  }
  const Orientation orientation = OrientNormals(positions, normals);
  EXPECT_EQ(orientation.pieces, 2u);
  EXPECT_EQ(orientation.flipped, 500u);
}

TEST(OrientNormalsTest, ConsistentCloudsStayAsTheyAre) {
  for (const std::string_view name : SurfaceNames()) {
    const auto surface = *MakeSurface(name);
    const std::vector<Vec3> positions = *SampleEvenly(*surface, 2000, 0);
    // The cylinder is open, but its normals cancel out: it counts as closed, and its normals do point outward.
    EXPECT_EQ(OrientNormals(positions, ExactNormals(*surface, positions)).flipped, 0u) << name;
  }
}

TEST(OrientNormalsTest, PointsAtOnePlaceKeepTheSideOfTheMajority) {
  // Whichever point all others are compared with, it is once of the majority, once of the minority.
  for (const bool first_of_three : {false, true}) {
    std::vector<Vec3> normals;
    for (size_t i = 0; i < 30; ++i) normals.push_back({0, 0, (i % 3 == 0) == first_of_three ? -1.0 : 1.0});
    const Orientation orientation = OrientNormals(std::vector<Vec3>(30, {1, 2, 3}), normals);
    EXPECT_EQ(orientation.flipped, 10u) << first_of_three;
  }
}

TEST(OrientNormalsTest, CoordinatesMayBeOfAnySize) {
  const auto sphere = *MakeSurface("sphere");
  const std::vector<Vec3> normals = *SampleEvenly(*sphere, 500, 0);
  for (const double size : {1e-300, 1e-170, 1e170, 1e307}) {
    std::vector<Vec3> positions = normals;
    for (Vec3& position : positions) position = size * position;
    EXPECT_EQ(OutwardShare(positions, normals), 1.0) << size;
  }
}

TEST(OrientNormalsTest, LeavesUnusablePointsAlone) {
  const std::vector<Vec3> positions = {{0, 0, 0}, {NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  const std::vector<Vec3> normals = {{0, 0, 1}, {0, 0, -1}, {0, 0, 0}, {0, INFINITY, 1}, {0, 0, 1}};
  const Orientation orientation = OrientNormals(positions, normals);
  EXPECT_EQ(orientation.flipped, 0u);
  EXPECT_EQ(orientation.flip.size(), 5u);
  EXPECT_EQ(OrientNormals({}, {}).pieces, 0u);
}

}  // namespace
}  // namespace curv
