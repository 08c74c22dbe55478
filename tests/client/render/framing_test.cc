#include "client/render/framing.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace curv {
namespace {

TEST(DiscRadiiTest, AreTheWayToTheSixthNeighbor) {
  std::vector<Vec3> line;
  for (int i = 0; i < 41; ++i) line.push_back({0.03125 * i, 0, 0});
  const std::vector<double> radii = DiscRadii(line);
  EXPECT_EQ(radii[20], 3 * 0.03125);
  EXPECT_EQ(radii[0], 6 * 0.03125);
}

TEST(DiscRadiiTest, AreBoundedByTheMedianAndByTheCloud) {
  std::vector<Vec3> line;
  for (int i = 0; i < 41; ++i) line.push_back({0.0078125 * i, 0, 0});
  line.push_back({2, 0, 0});
  EXPECT_EQ(DiscRadii(line).back(), 4 * 3 * 0.0078125);
  EXPECT_EQ(DiscRadii({{0, 0, 0}, {1.5, 0, 0}}), (std::vector<double>{0.25, 0.25}));
}

TEST(DiscRadiiTest, PointsAtOnePlaceAreLikeOthers) {
  std::vector<Vec3> line;
  for (int i = 0; i < 41; ++i) line.push_back({0.03125 * i, 0, 0});
  line.insert(line.end(), 7, {0.5, 1, 0});
  const std::vector<double> radii = DiscRadii(line);
  EXPECT_EQ(radii.back(), 3 * 0.03125);
  EXPECT_EQ(DiscRadii(std::vector<Vec3>(9, {1, 1, 1})), std::vector<double>(9, 1.0));
  std::vector<Vec3> two_places(7, {0, 0, 0});
  two_places.insert(two_places.end(), 7, {0, 0, 1.5});
  EXPECT_EQ(DiscRadii(two_places), std::vector<double>(14, 0.25));
}

TEST(FitFrameTest, DiscsTouchTheMargin) {
  // A disc reaches as far to a side as it faces the viewer.
  std::vector<Disc> discs;
  for (int i = 0; i < 101; ++i) discs.push_back({{0.01 * i, 0, 0}, {0, 0, 1}, 0.05});
  const Framing framing = FitFrame(discs, 300, 200, 10);
  EXPECT_DOUBLE_EQ(framing.scale, 280 / 1.1);
  EXPECT_DOUBLE_EQ(framing.center.x, 0.5);
  for (Disc& disc : discs) disc.normal = {1, 0, 0};
  EXPECT_DOUBLE_EQ(FitFrame(discs, 300, 200, 10).scale, 280.0);
}

TEST(FitFrameTest, AFrameHasRoomForFourDiscs) {
  const Framing framing = FitFrame({{{7, 8, 9}, {0, 0, 1}, 1.0}}, 100, 300, 10);
  EXPECT_DOUBLE_EQ(framing.scale, 80.0 / 8.0);
  EXPECT_EQ(framing.center, (Vec3{7, 8, 9}));
}

}  // namespace
}  // namespace curv
