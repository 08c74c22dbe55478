#include "proto/nearest_word.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

TEST(NearestWordTest, CountsLetters) {
  EXPECT_EQ(EditDistance("", "abc"), 3u);
  EXPECT_EQ(EditDistance("same", "same"), 0u);
  EXPECT_EQ(EditDistance("estmate", "estimate"), 1u);
  EXPECT_EQ(EditDistance("--outptu", "--output"), 1u);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
}

TEST(NearestWordTest, FindsTheNearestIfOneIsNear) {
  EXPECT_EQ(NearestWord("estmate", {"evaluate", "estimate"}), "estimate");
  EXPECT_EQ(NearestWord("ab", {"ac", "ad"}), "ac");
  EXPECT_EQ(NearestWord("paint", {"evaluate", "token"}), "");
  EXPECT_EQ(NearestWord(std::string(100, 'x'), {std::string(99, 'x')}), "");
  EXPECT_EQ(NearestWord("x", {}), "");
}

TEST(NearestWordTest, AsksOnlyWhereOneIsNear) {
  EXPECT_EQ(DidYouMean("--pionts", {"--points"}), "; did you mean --points?");
  EXPECT_EQ(DidYouMean("--colour-map", {"--points"}), "");
}

}  // namespace
}  // namespace curvd
