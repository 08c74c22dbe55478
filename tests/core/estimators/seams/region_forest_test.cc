#include "core/estimators/seams/region_forest.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace curvd {
namespace {

TEST(RegionForestTest, PointsAreRegionsUntilTheyAreJoined) {
  RegionForest regions = *RegionForest::Create(5);
  EXPECT_TRUE(regions.Join(0, 3));
  EXPECT_TRUE(regions.Join(4, 3));
  EXPECT_FALSE(regions.Join(0, 4));
  EXPECT_FALSE(regions.Join(2, 2));
  for (size_t point = 0; point < 5; ++point) regions.Measure(point);
  for (const size_t point : {0, 3, 4}) EXPECT_EQ(regions.MeasuredSize(point), 3u);
  for (const size_t point : {1, 2}) EXPECT_EQ(regions.MeasuredSize(point), 1u);
}

TEST(RegionForestTest, JoinsOfMeasuredRegionsKeepAMeasure) {
  RegionForest regions = *RegionForest::Create(4);
  regions.Join(0, 1);
  regions.Join(2, 3);
  for (size_t point = 0; point < 4; ++point) regions.Measure(point);
  EXPECT_TRUE(regions.Join(1, 3));
  EXPECT_FALSE(regions.Join(0, 2));
  for (size_t point = 0; point < 4; ++point) EXPECT_EQ(regions.MeasuredSize(point), 2u);
}

// Every thread joins the same pairs, each in an order of its own.
TEST(RegionForestTest, ThreadsJoinEachPairOnce) {
  constexpr size_t kPoints = 100'003, kThreads = 8, kStep = 7;
  RegionForest regions = *RegionForest::Create(kPoints);
  std::vector<size_t> joined(kThreads);
  std::vector<std::thread> threads;
  for (size_t thread = 0; thread < kThreads; ++thread) {
    threads.emplace_back([&, thread] {
      for (size_t i = 0; i < kPoints; ++i) {
        const size_t point = thread % 2 == 0 ? (i + thread * 12'345) % kPoints : kPoints - 1 - i;
        if (point >= kStep) joined[thread] += regions.Join(point, point - kStep) ? 1 : 0;
      }
    });
  }
  size_t all = 0;
  for (size_t thread = 0; thread < kThreads; ++thread) {
    threads[thread].join();
    all += joined[thread];
  }
  EXPECT_EQ(all, kPoints - kStep);
  for (size_t point = 0; point < kPoints; ++point) regions.Measure(point);
  for (size_t point = 0; point < kPoints; ++point) {
    ASSERT_EQ(regions.MeasuredSize(point), kPoints / kStep + (point % kStep < kPoints % kStep ? 1 : 0));
  }
}

}  // namespace
}  // namespace curvd
