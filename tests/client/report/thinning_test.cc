#include "client/report/thinning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace curv {
namespace {

TEST(IndexHashTest, GivesNoTwoIndicesTheSame) {
  std::vector<uint32_t> hashes;
  for (uint32_t i = 0; i < 1'000'000; ++i) hashes.push_back(IndexHash(i));
  std::sort(hashes.begin(), hashes.end());
  EXPECT_EQ(std::adjacent_find(hashes.begin(), hashes.end()), hashes.end());
}

TEST(ChoosePointsTest, KeepsAllOfASmallCloud) {
  EXPECT_THAT(ChoosePoints(4, 4).chosen, ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(ChoosePoints(1, 10).chosen, ::testing::ElementsAre(0));
}

TEST(ChoosePointsTest, KeepsAsManyAsAskedAndSaysWhich) {
  for (const size_t most : {1u, 7u, 1000u, 9999u}) {
    const Thinning thinning = ChoosePoints(10'000, most);
    EXPECT_EQ(thinning.chosen.size(), most);
    EXPECT_TRUE(std::is_sorted(thinning.chosen.begin(), thinning.chosen.end()));
    for (const uint32_t i : thinning.chosen) EXPECT_LE(IndexHash(i), thinning.limit);
  }
}

TEST(ChoosePointsTest, ChoosesEvenlyOverTheFile) {
  const Thinning thinning = ChoosePoints(1'000'000, 100'000);
  std::vector<int> in_tenth(10);
  for (const uint32_t i : thinning.chosen) ++in_tenth[i / 100'000];
  // A random choice has a standard deviation of 95.
  for (const int count : in_tenth) EXPECT_NEAR(count, 10'000, 500);
}

}  // namespace
}  // namespace curv
