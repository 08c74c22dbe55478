#include "core/estimators/seams/one_sheet.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace curvd::testing {
namespace {

SheetHeights Heights(std::initializer_list<double> values) {
  SheetHeights heights;
  for (const double value : values) heights.Add(value);
  return heights;
}

TEST(SheetHeightsTest, TellsMeanAndSpread) {
  const SheetHeights heights = Heights({1.0, 3.0, 1.0, 3.0});
  EXPECT_EQ(heights.count(), 4u);
  EXPECT_EQ(heights.Mean(), 2.0);
  EXPECT_EQ(heights.Spread(), 1.0);
  EXPECT_EQ(SheetHeights().Mean(), 0.0);
  EXPECT_EQ(SheetHeights().Spread(), 0.0);
}

TEST(LieOnOneSheetTest, AFlatSheetIsOneToTheLastBit) {
  EXPECT_TRUE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0, 0}), 1.0));
  EXPECT_TRUE(LieOnOneSheet(Heights({0}), Heights({0}), 0.0));  // points that coincide
}

TEST(LieOnOneSheetTest, AnotherSheetIsTwoHoweverWideTheNoise) {
  EXPECT_FALSE(LieOnOneSheet(Heights({0, 0, 0}), Heights({-0.8, -0.8}), 1.0));
  EXPECT_FALSE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.8, 0.8}), 1.0));
  EXPECT_FALSE(LieOnOneSheet(Heights({-1, 0, 1}), Heights({0.31, 0.31}), 1.0));
  EXPECT_FALSE(LieOnOneSheet(Heights({0}), Heights({0.31}), 1.0));
  EXPECT_FALSE(LieOnOneSheet(Heights({0}), Heights({0.02}), 1.0));
}

// A knife: exact faces, a few hundredths of the distance apart at its edge.
TEST(LieOnOneSheetTest, LowHeightsAreTwoSheetsWherePointsAreExact) {
  EXPECT_FALSE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.03, 0.05}), 1.0));
  EXPECT_TRUE(LieOnOneSheet(Heights({-0.05, 0, 0.05}), Heights({0.03, 0.05}), 1.0));
  EXPECT_TRUE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.005, 0.012}), 1.0));
}

TEST(LieOnOneSheetTest, APointAwayFromItsSheetChangesNothing) {
  for (const double above : {-0.7, 0.0, 0.7}) {
    EXPECT_TRUE(LieOnOneSheet(Heights({above, above - 0.1, above + 0.1}), Heights({above}), 1.0));
    EXPECT_FALSE(LieOnOneSheet(Heights({above, above - 0.1, above + 0.1}), Heights({above - 0.8}), 1.0));
  }
}

TEST(LieOnOneSheetTest, InDoubtOnlyTheHeightCounts) {
  EXPECT_TRUE(MayLieOnOneSheet(Heights({0, 0, 0}), Heights({0.25}), 1.0));
  EXPECT_FALSE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.25}), 1.0));
  EXPECT_FALSE(MayLieOnOneSheet(Heights({-1, 0, 1}), Heights({0.31}), 1.0));
}

TEST(LieOnOneSheetTest, LengthsHaveNoUnit) {
  for (const double unit : {1e-12, 1.0, 1e12}) {
    EXPECT_TRUE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.009 * unit}), unit));
    EXPECT_FALSE(LieOnOneSheet(Heights({0, 0, 0}), Heights({0.03 * unit}), unit));
  }
}

}  // namespace
}  // namespace curvd::testing
