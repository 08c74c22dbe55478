#include "core/estimators/seams/seam_marks.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

constexpr size_t kGroups = 64;
constexpr size_t kTogether = 1'024;  // places that are judged together

SeamMarks NoMarks() { return *SeamMarks::Create(kGroups); }

TEST(SeamMarksTest, MarksAreThoseOfThePlaces) {
  SeamMarks marks = NoMarks();
  marks.Mark(35, false);
  marks.Mark(47, true);
  EXPECT_TRUE(marks.IsMarked(35) && marks.IsMarked(47));
  EXPECT_FALSE(marks.IsMarked(36) || marks.IsMarked(35 + 64));
  EXPECT_EQ(marks.InLeaf(2), uint32_t{1} << 3 | uint32_t{1} << 15);
  EXPECT_EQ(marks.InLeaf(3), 0u);
  EXPECT_EQ(marks.SurePoints(), 1u);
}

TEST(SeamMarksTest, ASinglePointWithoutDoubtShowsASeam) {
  SeamMarks marks = NoMarks();
  EXPECT_FALSE(marks.ShowSeam());
  marks.Mark(2'000, true);
  EXPECT_TRUE(marks.ShowSeam());
}

TEST(SeamMarksTest, DoubtAloneShowsNone) {
  SeamMarks marks = NoMarks();
  for (size_t place = 0; place < kGroups * 64; place += 3) marks.Mark(place, false);
  EXPECT_FALSE(marks.ShowSeam());
}

TEST(SeamMarksTest, FewWithoutDoubtAmongManyAreChance) {
  SeamMarks marks = NoMarks();
  // Chance leaves 1 + 4 + 4 sqrt(4) = 13 of 100.
  for (size_t place = 0; place < 100; ++place) marks.Mark(kTogether + 100 + place, place < 13);
  EXPECT_FALSE(marks.ShowSeam());
  marks.Mark(kTogether + 113, true);
  EXPECT_TRUE(marks.ShowSeam());
}

TEST(SeamMarksTest, DoubtElsewhereDoesNotHideASeam) {
  SeamMarks marks = NoMarks();
  for (size_t place = 0; place < kTogether; ++place) marks.Mark(place, false);
  for (size_t place = 0; place < 6; ++place) marks.Mark(2 * kTogether + place, true);
  EXPECT_TRUE(marks.ShowSeam());
}

TEST(SeamMarksTest, FewPointsShowASeamIfNearlyAllHaveNoDoubt) {
  SeamMarks marks = NoMarks();
  marks.Mark(7, true);
  marks.Mark(8, false);
  marks.Mark(9, true);
  EXPECT_FALSE(marks.ShowSeam());
  marks.Mark(10, true);
  EXPECT_TRUE(marks.ShowSeam());
}

}  // namespace
}  // namespace curvd
