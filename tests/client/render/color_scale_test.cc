#include "client/render/color_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace curv {
namespace {

void ExpectColor(const Color& color, int red, int green, int blue) {
  // The published table of the map is rounded to bytes.
  EXPECT_NEAR(ToByte(color.red), red, 2);
  EXPECT_NEAR(ToByte(color.green), green, 2);
  EXPECT_NEAR(ToByte(color.blue), blue, 2);
}

TEST(DivergingColorTest, HasThePublishedColors) {
  ExpectColor(DivergingColor(-1), 59, 76, 192);
  ExpectColor(DivergingColor(0), 221, 221, 221);
  ExpectColor(DivergingColor(1), 180, 4, 38);
}

TEST(DivergingColorTest, ChangesGraduallyAndClamps) {
  for (double t = -1; t < 1; t += 0.01) {
    const Color a = DivergingColor(t), b = DivergingColor(t + 0.01);
    EXPECT_LT(std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue), 0.05);
  }
  EXPECT_EQ(DivergingColor(-7).red, DivergingColor(-1).red);
  EXPECT_EQ(DivergingColor(std::numeric_limits<double>::infinity()).red, DivergingColor(1).red);
}

TEST(ColorScaleTest, ZeroIsTheMiddle) {
  const ColorScale scale(-0.1, 0.3);
  EXPECT_EQ(scale.ColorOf(0.0).red, DivergingColor(0).red);
  EXPECT_EQ(scale.ColorOf(-0.05).blue, DivergingColor(-0.5).blue);
  EXPECT_EQ(scale.ColorOf(0.15).green, DivergingColor(0.5).green);
  EXPECT_EQ(scale.ColorOf(9).green, DivergingColor(1).green);
}

TEST(ColorScaleTest, SpreadsTheMapWhereZeroIsOutside) {
  const ColorScale scale(1, 3);
  EXPECT_EQ(scale.ColorOf(1).red, DivergingColor(-1).red);
  EXPECT_EQ(scale.ColorOf(2).red, DivergingColor(0).red);
}

TEST(ColorScaleTest, NanIsGrey) { EXPECT_EQ(ColorScale(-1, 1).ColorOf(NAN).red, kNoValueColor.red); }

TEST(ColorScaleTest, ChoosesASymmetricRangeWithoutOutliers) {
  std::vector<double> values(1000, 0.5);
  for (size_t i = 0; i < 500; ++i) values[i] = -0.25;
  values[0] = 1e6;
  values[1] = NAN;
  values[2] = INFINITY;
  const ColorScale scale = ColorScale::ForValues(values);
  EXPECT_EQ(scale.low(), -0.5);
  EXPECT_EQ(scale.high(), 0.5);
}

TEST(ColorScaleTest, ChoosesSomeRangeForNothingAndForZeros) {
  EXPECT_LT(ColorScale::ForValues({}).low(), ColorScale::ForValues({}).high());
  EXPECT_EQ(ColorScale::ForValues(std::vector<double>{0, 0}).high(), 1.0);
}

TEST(ColorScaleTest, IsOfFiniteWidthForTheLargestNumbers) {
  const ColorScale scale = ColorScale::ForValues(std::vector<double>{1.7e308, -1.7e308});
  EXPECT_TRUE(std::isfinite(scale.high() - scale.low()));
  EXPECT_GT(scale.high(), 8e307);
}

}  // namespace
}  // namespace curv
