// The K nearest points of a list of leaves, whatever distance they are guessed at, on each instruction set that this
// machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/search/neighborhood_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The neighborhood of a query among all leaves of an index, by a guess from low to high; false if none was found.
bool CallNearest(const SpatialIndex& index, const float* query, size_t k, float low, float high, float squared_reach,
                 SearchScratch& s) {
  const Box box = {{query[0], query[1], query[2]}, {query[0], query[1], query[2]}};
  GatherLeaves(index, box, squared_reach, index.leaf_count(), s.group_leaves, s.work);
  return NearestInReach(index, s.group_leaves, query, k, {low, high}, squared_reach, s);
}

// The ids of the neighbors that were found last, to `ids`; returns their number.
size_t CallListInside(const SpatialIndex& index, const Neighborhood& found, int32_t* ids) {
  size_t count = 0;
  const auto list = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    for (uint64_t bits = BitsFromMask(inside); bits != 0; bits &= bits - 1) {
      ids[count++] = index.positions(near.leaf).id[near.place + static_cast<size_t>(std::countr_zero(bits))];
    }
  };
  ForEachInside(index, found, list);
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd {
HWY_EXPORT(CallNearest);
HWY_EXPORT(CallListInside);

namespace testing {
namespace {

using NeighborhoodTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, NeighborhoodTest, InstructionSets(), InstructionSetName);

// Squared distances, as kernels round them, and ids of all points of an index: the nearest first, ties by id.
std::vector<std::pair<float, int32_t>> Ranked(const SpatialIndex& index, const float* query) {
  std::vector<std::pair<float, int32_t>> ranked;
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const float x = points.x[i] - query[0], y = points.y[i] - query[1], z = points.z[i] - query[2];
      ranked.emplace_back((x * x + y * y) + z * z, points.id[i]);
    }
  }
  std::sort(ranked.begin(), ranked.end());
  return ranked;
}

TEST_P(NeighborhoodTest, GuessesSeedTheSearchAlone) {
  for (const Layout layout : kLayouts) {
    const SpatialIndex index = BuildIndex(RandomPoints(layout, 900, 5).ToCloud());
    const SpatialIndex::LeafPositions& leaf = index.positions(index.leaf_count() / 2);
    const float query[3] = {leaf.x[3], leaf.y[3], leaf.z[3]};
    const std::vector<std::pair<float, int32_t>> ranked = Ranked(index, query);
    SearchScratch scratch;
    std::vector<int32_t> ids(ranked.size());
    for (const size_t k : {1, 4, 15, 50, 300}) {
      std::vector<int32_t> expected(k);
      for (size_t i = 0; i < k; ++i) expected[i] = ranked[i].second;
      std::sort(expected.begin(), expected.end());
      const float kth = ranked[k - 1].first, reach = std::max(4.0f * kth, ranked[k].first);
      // Around the K-th distance, at it, and on either side of it; a guess of no width, and none.
      const std::pair<float, float> guesses[] = {{0.9f * kth, 1.1f * kth},
                                                 {kth, 1.1f * kth},
                                                 {0.9f * kth, kth},
                                                 {0.2f * kth, 0.5f * kth},
                                                 {2.0f * kth, 3.0f * kth},
                                                 {kth, kth},
                                                 {0.0f, 0.0f},
                                                 {9.0f * kth, 9.0f * kth},
                                                 {-1.0f, reach}};
      for (const auto& [low, high] : guesses) {
        ASSERT_TRUE(HWY_DYNAMIC_DISPATCH(CallNearest)(index, query, k, low, high, reach, scratch));
        ASSERT_EQ(scratch.found.count, k);
        ASSERT_EQ(HWY_DYNAMIC_DISPATCH(CallListInside)(index, scratch.found, ids.data()), k)
            << LayoutName(layout) << " k " << k << " guess " << low << " to " << high;
        std::sort(ids.begin(), ids.begin() + static_cast<ptrdiff_t>(k));
        ASSERT_TRUE(std::equal(expected.begin(), expected.end(), ids.begin()))
            << LayoutName(layout) << " k " << k << " guess " << low << " to " << high;
      }
    }
  }
}

TEST_P(NeighborhoodTest, TellsThatFewerPointsAreInReach) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 900, 5).ToCloud());
  const SpatialIndex::LeafPositions& leaf = index.positions(7);
  const float query[3] = {leaf.x[3], leaf.y[3], leaf.z[3]};
  const float reach = Ranked(index, query)[48].first;  // 49 points
  SearchScratch scratch;
  for (const float guess : {0.0f, 0.1f, 0.9f, 1.0f, 2.0f}) {
    EXPECT_TRUE(
        HWY_DYNAMIC_DISPATCH(CallNearest)(index, query, 49, 0.8f * guess * reach, guess * reach, reach, scratch));
    EXPECT_FALSE(
        HWY_DYNAMIC_DISPATCH(CallNearest)(index, query, 50, 0.8f * guess * reach, guess * reach, reach, scratch));
  }
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
