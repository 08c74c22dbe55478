#include "core/scale/edges/normal_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

// Normals of faces that have these, one after the other.
std::vector<NeighborNormal> Faces(const std::vector<Vector3d>& normals, size_t of_each) {
  std::vector<NeighborNormal> neighbors;
  for (size_t i = 0; i < of_each; ++i) {
    for (const Vector3d& normal : normals) neighbors.push_back({Vector3d::Zero(), normal});
  }
  return neighbors;
}

// Normals that turn evenly by so much in all.
std::vector<NeighborNormal> Bend(double angle) {
  std::vector<NeighborNormal> neighbors;
  for (int i = 0; i < 96; ++i) {
    const double at = angle * (i / 95.0 - 0.5);
    neighbors.push_back({Vector3d::Zero(), Vector3d(std::sin(at), 0.0, std::cos(at))});
  }
  return neighbors;
}

TEST(NormalFacesTest, FacesLeaveNothing) {
  const NormalSpread two = SpreadOf(Faces({Vector3d::UnitX(), Vector3d::UnitZ()}, 16));
  EXPECT_NEAR(two.all, 0.5, 1e-12);
  EXPECT_LT(two.in_two, 1e-12);
  EXPECT_TRUE(AreOfFaces(two, 0.0));
  const NormalSpread three = SpreadOf(Faces({Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}, 10));
  EXPECT_NEAR(three.all, 2.0 / 3.0, 1e-12);
  EXPECT_GT(three.in_two, 0.3);
  EXPECT_LT(three.in_three, 1e-12);
  EXPECT_TRUE(AreOfFaces(three, 0.0)) << "a corner";
}

TEST(NormalFacesTest, BendsAreNoFaces) {
  const NormalSpread bend = SpreadOf(Bend(0.5));
  // Lloyd's method is not done after its rounds.
  EXPECT_NEAR(bend.in_two / bend.all, 1.0 / 4.0, 0.01);
  EXPECT_NEAR(bend.in_three / bend.all, 1.0 / 9.0, 0.03);
  EXPECT_FALSE(AreOfFaces(bend, 0.0));
}

TEST(NormalFacesTest, ClustersOfFewerThanThreeAreNoFaces) {
  std::vector<NeighborNormal> neighbors = Faces({Vector3d::UnitZ()}, 30);
  neighbors.push_back({Vector3d::Zero(), Vector3d::UnitX()});
  neighbors.push_back({Vector3d::Zero(), Vector3d::UnitX()});
  const NormalSpread spread = SpreadOf(neighbors);
  EXPECT_EQ(spread.in_two, spread.all);
  EXPECT_EQ(spread.in_three, spread.all);
  EXPECT_FALSE(AreOfFaces(spread, 0.0));
}

TEST(NormalFacesTest, NoiseIsTakenOff) {
  // What is left in two clusters is 0.1 squared along each tangent, a quarter of the spread.
  const NormalSpread spread{0.08, 0.02, 0.02};
  EXPECT_FALSE(AreOfFaces(spread, 0.0));
  EXPECT_TRUE(AreOfFaces(spread, 0.1));
}

}  // namespace
}  // namespace curvd::testing
