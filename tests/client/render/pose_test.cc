#include "client/render/pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "client/surfaces/surface.h"

namespace curv {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

struct Cloud {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;

  void Add(const Vec3& position, const Vec3& normal) {
    positions.push_back(position);
    normals.push_back(normal);
  }
  Pose Choose() const { return ChoosePose(positions, normals); }
};

// Turns z up into y up, as the view does.
Cloud WithYUp(Cloud cloud) {
  for (auto* vectors : {&cloud.positions, &cloud.normals}) {
    for (Vec3& v : *vectors) v = {v.x, v.z, -v.y};
  }
  return cloud;
}

// Adds an ellipsoid of these semi-axes; its points that are lower than `cut` of its height are missing.
void AddEllipsoid(const Vec3& center, const Vec3& axes, Cloud& cloud, double cut = -1.0) {
  constexpr int kPoints = 3000;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1 - (2 * i + 1.0) / kPoints, ring = std::sqrt(1 - z * z), angle = 2.39996 * i;
    if (z < cut) continue;
    const Vec3 on_sphere{ring * std::cos(angle), ring * std::sin(angle), z};
    cloud.Add(center + Vec3{axes.x * on_sphere.x, axes.y * on_sphere.y, axes.z * on_sphere.z},
              Normalized({on_sphere.x / axes.x, on_sphere.y / axes.y, on_sphere.z / axes.z}));
  }
}

Cloud Terrain() {
  Cloud cloud;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      cloud.Add({500'000.0 + i, 5'800'000.0 + j, 100 + 5 * std::sin(0.1 * i)},
                Normalized({-0.5 * std::cos(0.1 * i), 0, 1}));
    }
  }
  return cloud;
}

// A figure that stands along z, the same to its left and its right (x), with arms to the front (-y) and a tail behind.
Cloud Figure() {
  Cloud cloud;
  for (const double side : {-1.0, 1.0}) {
    AddEllipsoid({0.9 * side, 0.4, -3.0}, {0.5, 0.5, 1.6}, cloud);
    AddEllipsoid({1.5 * side, -1.6, 1.0}, {0.4, 1.4, 0.4}, cloud);
  }
  AddEllipsoid({0, -0.3, 0}, {1.3, 0.8, 1.6}, cloud);
  AddEllipsoid({0, -0.9, 2.5}, {0.7, 1.0, 0.8}, cloud);
  AddEllipsoid({0, 1.8, -1.5}, {0.3, 1.5, 0.3}, cloud);
  return cloud;
}

TEST(PoseTest, TerrainLiesOnItsBackAndIsSeenFromAbove) {
  const Pose pose = Terrain().Choose();
  EXPECT_EQ(pose.up_axis, 'z');
  EXPECT_EQ(pose.elevation, 45.0);
  EXPECT_THAT(pose.reason, HasSubstr("open"));
  EXPECT_EQ(WithYUp(Terrain()).Choose().up_axis, 'y');
}

TEST(PoseTest, TerrainWithoutNormalsLiesFlat) {
  EXPECT_EQ(ChoosePose(Terrain().positions, {}).up_axis, 'z');
  EXPECT_EQ(ChoosePose(WithYUp(Terrain()).positions, {}).up_axis, 'y');
}

TEST(PoseTest, WhatAScanHasNotSeenIsBelow) {
  Cloud bust;
  AddEllipsoid({0, 0, 0}, {1, 2, 1.5}, bust, -0.5);
  EXPECT_EQ(bust.Choose().up_axis, 'z');
  EXPECT_EQ(WithYUp(bust).Choose().up_axis, 'y');
}

TEST(PoseTest, FiguresStand) {
  EXPECT_EQ(Figure().Choose().up_axis, 'z');
  EXPECT_EQ(WithYUp(Figure()).Choose().up_axis, 'y');
  EXPECT_THAT(WithYUp(Figure()).Choose().reason, HasSubstr("taller"));
}

TEST(PoseTest, WhatHasLeftAndRightAlongOneAxisStandsOnTheOther) {
  // A boat: left and right along y, longer than it is high, with more below than above.
  Cloud boat;
  AddEllipsoid({0, 0, 0}, {6, 2, 1}, boat);
  AddEllipsoid({3, 0, -1.2}, {2, 0.4, 1}, boat);
  AddEllipsoid({-3, 0, -2.2}, {0.6, 0.3, 1.5}, boat);
  EXPECT_EQ(boat.Choose().up_axis, 'z');
  EXPECT_THAT(boat.Choose().reason, HasSubstr("mirror"));
  EXPECT_EQ(WithYUp(boat).Choose().up_axis, 'y');
}

TEST(PoseTest, SurfacesThatSayNothingKeepTheUsualPose) {
  for (const char* name : {"sphere", "torus", "goursat", "ellipsoid"}) {
    const auto surface = *MakeSurface(name);
    Cloud cloud;
    const std::vector<Vec3> points = *SampleEvenly(*surface, 5000, 0);
    for (const Vec3& p : points) cloud.Add(p, surface->At(p).normal);
    const Pose pose = cloud.Choose();
    EXPECT_EQ(pose.up_axis, 'z') << name;
    EXPECT_EQ(pose.azimuth, 35.0) << name;
    EXPECT_EQ(pose.elevation, 25.0) << name;
  }
}

TEST(PoseTest, AnOpenSideIsTurnedToTheViewer) {
  // Half a sphere that only a scanner at +y saw: from the usual side it shows its inside.
  Cloud cloud;
  AddEllipsoid({0, 0, 0}, {1, 1, 1}, cloud, 0.0);
  for (auto* vectors : {&cloud.positions, &cloud.normals}) {
    for (Vec3& v : *vectors) v = {v.x, v.z, -v.y};
  }
  const Pose pose = ChoosePose(cloud.positions, cloud.normals, 'z');
  EXPECT_THAT(pose.azimuth, AnyOf(170.0, 215.0)) << "+y is at 180";
}

TEST(PoseTest, KeepsTheUpAxisThatWasAskedFor) {
  const Cloud terrain = Terrain();
  EXPECT_EQ(ChoosePose(terrain.positions, terrain.normals, 'y').up_axis, 'y');
}

TEST(PoseTest, DependsOnNoUnitAndOnNoOrder) {
  Cloud cloud = WithYUp(Figure());
  const Pose expected = cloud.Choose();
  std::reverse(cloud.positions.begin(), cloud.positions.end());
  std::reverse(cloud.normals.begin(), cloud.normals.end());
  for (const double scale : {1e-300, 1e-6, 1e6, 1e300}) {
    Cloud scaled = cloud;
    for (Vec3& p : scaled.positions) p = scale * p;
    const Pose pose = scaled.Choose();
    EXPECT_EQ(pose.up_axis, expected.up_axis) << scale;
    EXPECT_EQ(pose.azimuth, expected.azimuth) << scale;
  }
}

TEST(PoseTest, SurvivesOddClouds) {
  const double nan = NAN;
  for (const std::vector<Vec3>& positions :
       {std::vector<Vec3>{}, std::vector<Vec3>{{nan, 0, 0}}, std::vector<Vec3>{{1, 2, 3}},
        std::vector<Vec3>(20, {5, 5, 5}), std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}},
        std::vector<Vec3>{{-1.7e308, 0, 0}, {1.7e308, 0, nan}, {1.7e308, 0, 0}}}) {
    for (const Vec3& normal : {Vec3{}, Vec3{nan, 1, 0}, Vec3{0, 0, 1}}) {
      const Pose pose = ChoosePose(positions, std::vector<Vec3>(positions.size(), normal));
      EXPECT_TRUE(pose.up_axis == 'y' || pose.up_axis == 'z');
      EXPECT_TRUE(std::isfinite(pose.azimuth));
    }
  }
}

}  // namespace
}  // namespace curv
