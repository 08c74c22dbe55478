#include "core/search/kth_neighbor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "tests/core/reference_estimator.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

TEST(KthNeighborTest, MatchesBruteForceTiesIncluded) {
  ScratchArray<NeighborRank> heap;
  for (Layout layout : kLayouts) {
    const TestPoints points = RandomPoints(layout, 900, 5);
    const SpatialIndex index = BuildIndex(points.ToCloud());
    for (size_t leaf = 0; leaf < index.leaf_count(); leaf += 7) {
      const auto& p = index.positions(leaf);
      const float query[3] = {p.x[0], p.y[0], p.z[0]};
      for (size_t k : {1, 7, 100, 900}) {
        const NeighborRank rank = KthNeighbor(index, query, k, heap);
        const std::vector<int> ids = NearestIds(points, p.id[0], k);
        // Where float and double order two neighbors differently, their distances agree to rounding.
        const auto distance = [&](int id) {
          double sum = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const double d = static_cast<double>(points.positions[id][axis]) - points.positions[p.id[0]][axis];
            sum += d * d;
          }
          return sum;
        };
        ASSERT_NEAR(distance(rank.id), distance(ids.back()), 1e-6 * distance(ids.back())) << LayoutName(layout);
        if (layout == Layout::kDuplicates || layout == Layout::kLattice) {
          ASSERT_EQ(rank.id, ids.back());
        }
      }
    }
  }
}

TEST(KthNeighborTest, CoincidentPointsDoNotMakeItSlow) {
  // 200,000 equal points: a search that visited all ties would look at 4e10 of them for these queries.
  TestPoints points;
  for (int i = 0; i < 200'000; ++i) points.Add(1, 1, 1, 0, 0, 1);
  const SpatialIndex index = BuildIndex(points.ToCloud());
  const float query[3] = {1, 1, 1};
  ScratchArray<NeighborRank> heap;
  for (int i = 0; i < 200'000; ++i) ASSERT_EQ(KthNeighbor(index, query, 20, heap).id, 19);
}

// From the center of a sphere of points every leaf may hold the nearest one.
TEST(KthNeighborTest, CountsItsStepsAndLooksAtNoPointTwice) {
  constexpr size_t kPoints = 20'000;
  const SpatialIndex index = BuildIndex(Sphere(kPoints, 1.0).ToCloud());
  const float center[3] = {0, 0, 0},
              pole[3] = {index.positions(0).x[0], index.positions(0).y[0], index.positions(0).z[0]};
  ScratchArray<NeighborRank> heap;
  uint64_t work = 0;
  KthNeighbor(index, center, 20, heap, {.work = &work});
  EXPECT_GT(work, kPoints / 2);
  EXPECT_LE(work, kPoints + 2 * index.leaf_count());
  work = 0;
  KthNeighbor(index, pole, 20, heap, {.work = &work});
  EXPECT_LT(work, 1000u);
}

TEST(KthNeighborTest, AStoppedDescentFindsNoRank) {
  const SpatialIndex index = BuildIndex(Sphere(20'000, 1.0).ToCloud());
  const float center[3] = {0, 0, 0};
  ScratchArray<NeighborRank> heap;
  const std::atomic<bool> stopped = true;
  uint64_t work = 0;
  const NeighborRank rank = KthNeighbor(index, center, 20, heap, {.stopped = &stopped, .work = &work});
  EXPECT_LT(rank, (NeighborRank{0.0f, 0}));
  EXPECT_EQ(work, 0u);
}

}  // namespace
}  // namespace curvd::testing
