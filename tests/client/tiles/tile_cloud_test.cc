#include "client/tiles/points/tile_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "client/tiles/lattice.h"
#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

constexpr double kSpacing = 0x1p-10;

// Two points that are `steps` of the lattice apart, far from zero.
FloatArrays TwoPoints(double steps, bool is_double) {
  TilePlan plan;
  plan.is_double = is_double;
  plan.spacing = is_double ? kSpacing : 0.0;
  TileCloud cloud;
  cloud.points.resize(2);
  for (const size_t i : {0, 1}) {
    cloud.points[i].position = {1024.0 + static_cast<double>(i) * steps * kSpacing, 2048.0, -512.0};
    cloud.points[i].id = i;
  }
  return ToFloats(plan, cloud);
}

TEST(ToFloatsTest, TellsTheLatticeOnWhichPositionsOfDoublesAre) {
  const FloatArrays arrays = TwoPoints(2.0 * (kMostSteps - 1.0), true);
  EXPECT_EQ(arrays.spacing, kSpacing);
  EXPECT_EQ(arrays.coarse_spacing, 0.0);
  for (const size_t i : {0, 3}) EXPECT_LE(std::abs(arrays.positions[i]) / kSpacing, kMostSteps);
}

TEST(ToFloatsTest, TakesACoarserLatticeWhereThePlansIsTooFine) {
  const FloatArrays arrays = TwoPoints(2.0 * kMostSteps + 2.0, true);
  EXPECT_EQ(arrays.spacing, 2.0 * kSpacing);
  EXPECT_EQ(arrays.coarse_spacing, 2.0 * kSpacing);
}

TEST(ToFloatsTest, LeavesFloatsWhereTheyAre) {
  const FloatArrays arrays = TwoPoints(2.0, false);
  EXPECT_EQ(arrays.spacing, 0.0);
  EXPECT_EQ(arrays.positions[3], 1024.0f + 2.0f * static_cast<float>(kSpacing));
}

// Reads balls around some points of a plan, and compares with all its points.
void CheckBalls(size_t step, bool is_exact) {
  constexpr size_t kPoints = 6000;
  const testing::ScratchDirectory scratch;
  const TilePlan plan =
      testing::PlanHills(scratch, kPoints, 1500, {.neighbor_count = 20, .radius = 0.0, .factor = 1.0});
  const absl::StatusOr<PointStore> store = PointStore::Open(plan);
  ASSERT_TRUE(store.ok()) << store.status();
  std::vector<TilePoint> all;
  ASSERT_TRUE(store->Append(0, kPoints, all).ok());
  std::vector<Ball> balls;
  for (size_t i = 0; i < kPoints; i += step) balls.push_back({all[i], 0.02 * static_cast<double>(1 + i % 40)});
  const absl::StatusOr<TileCloud> cloud = ReadBalls(*store, balls);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  std::set<uint64_t> read, asked;
  for (const TilePoint& point : cloud->points) read.insert(point.id);
  for (const uint32_t query : cloud->queries) asked.insert(cloud->points[query].id);
  ASSERT_EQ(read.size(), cloud->points.size());
  ASSERT_EQ(asked.size(), balls.size());
  for (const Ball& ball : balls) EXPECT_TRUE(asked.contains(ball.point.id));
  size_t in_balls = 0;
  for (const TilePoint& point : all) {
    const bool is_in_ball = std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) {
      return Box{point.position, point.position}.DistanceTo(ball.point.position) <= ball.distance;
    });
    in_balls += is_in_ball ? 1 : 0;
    EXPECT_TRUE(read.contains(point.id) || !is_in_ball) << "point " << point.id;
  }
  EXPECT_LE(read.size(), CountBalls(plan, balls));
  if (is_exact) {
    EXPECT_EQ(read.size(), in_balls);
  }
}

TEST(ReadBallsTest, ReadsWhatIsInFewBallsAlone) { CheckBalls(3001, true); }

TEST(ReadBallsTest, ReadsAllThatIsInManyBalls) { CheckBalls(7, false); }

}  // namespace
}  // namespace curv
