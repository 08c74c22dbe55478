#include "core/estimators/triangles/rank_numbers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kLeaf = SpatialIndex::kLeafSize;

void List(const SpatialIndex& index, const std::vector<uint32_t>& listed, LeafList& leaves) {
  leaves.Clear();
  for (const uint32_t leaf : listed) leaves.Add(index, leaf);
  leaves.Pad();
}

// Compares the numbers of a list with the places of its points' ranks in a sorted array of them.
void ExpectNumbersInOrder(const SpatialIndex& index, const std::vector<uint32_t>& listed, LeafList& leaves,
                          RankNumbers& numbers) {
  std::vector<int32_t> ranks;
  for (const uint32_t leaf : listed) {
    const int32_t* ids = index.positions(leaf).id;
    ranks.insert(ranks.end(), ids, ids + index.LeafPoints(leaf));
  }
  std::ranges::sort(ranks);
  List(index, listed, leaves);
  EXPECT_EQ(numbers.Start(index, leaves), ranks.size());
  ASSERT_EQ(numbers.size(), ranks.size());
  for (size_t position = 0; position < listed.size(); ++position) {
    const int32_t* ids = index.positions(listed[position]).id;
    for (int i = 0; i < index.LeafPoints(listed[position]); ++i) {
      const auto place = static_cast<int32_t>(std::ranges::lower_bound(ranks, ids[i]) - ranks.begin());
      EXPECT_EQ(numbers.of(position)[i], place) << "leaf " << position << " point " << i;
    }
  }
  for (size_t i = 0; i < listed.size() * kLeaf; ++i) EXPECT_EQ(numbers.slots()[i], RankNumbers::kEmpty) << i;
}

// Ranks of one digit to three; of a long list after a short one, and of a short one after a long one.
TEST(RankNumbersTest, NumbersThePointsOfLeavesByTheirRanks) {
  for (const size_t points : {7u, 200u, 3000u, 100'003u}) {
    const SpatialIndex index = BuildIndex(Sphere(points, 1.0).ToCloud());
    const auto last = static_cast<uint32_t>(index.leaf_count() - 1);
    LeafList leaves;
    RankNumbers numbers;
    std::vector<uint32_t> all;
    for (uint32_t leaf = 0; leaf <= last; leaf += 1 + last / 300) all.push_back(leaf);
    if (all.back() != last) all.push_back(last);  // where there may be places without a point
    ExpectNumbersInOrder(index, {0}, leaves, numbers);
    ExpectNumbersInOrder(index, all, leaves, numbers);
    ExpectNumbersInOrder(index, {last}, leaves, numbers);
    EXPECT_LE(numbers.bytes(), RankNumbers::MostBytes(all.size()));
  }
}

TEST(RankNumbersTest, NumbersAListOnce) {
  const SpatialIndex index = BuildIndex(Sphere(500, 1.0).ToCloud());
  LeafList leaves;
  List(index, {1, 2}, leaves);
  RankNumbers numbers;
  EXPECT_EQ(numbers.Start(index, leaves), 2 * kLeaf);
  EXPECT_EQ(numbers.Start(index, leaves), 0u);
  leaves.Add(index, 3);
  leaves.Pad();
  EXPECT_EQ(numbers.Start(index, leaves), 3 * kLeaf);
}

}  // namespace
}  // namespace curvd::testing
