#include "client/render/legend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace curv {
namespace {

constexpr Color kPaper{1, 1, 1};

bool IsPaper(const Color& color) { return color.red == 1.0f && color.green == 1.0f && color.blue == 1.0f; }

Image Drawn(const LegendText& text, int width = 400, int height = 300) {
  Image image(width, height, kPaper);
  DrawLegend(ColorScale(-1, 1), text, *MakeView("front", 'z'), image);
  return image;
}

// Pixels that differ between two pictures in rows [top, bottom).
size_t Differences(const Image& a, const Image& b, int top, int bottom) {
  size_t count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = 0; x < a.width; ++x) count += std::abs(a.at(x, y).green - b.at(x, y).green) > 0.1f ? 1 : 0;
  }
  return count;
}

TEST(LegendTest, StaysInItsPlace) {
  const Image image = Drawn({.title = "Mean curvature", .unit = "1/mm", .has_missing = true});
  const int left = 400 - LegendWidth(400, 300);
  size_t drawn = 0;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (x < left || x == 399 || y == 0 || y == 299) {
        EXPECT_TRUE(IsPaper(image.at(x, y))) << x << " " << y;
      }
      drawn += IsPaper(image.at(x, y)) ? 0 : 1;
    }
  }
  EXPECT_GT(drawn, 1000u);
}

TEST(LegendTest, LongUnitsEndWithAnEllipsis) {
  const Image some = Drawn({.title = "k", .unit = "1/" + std::string(100, 'm')});
  for (int y = 0; y < 300; ++y) EXPECT_TRUE(IsPaper(some.at(398, y))) << y;
  EXPECT_EQ(Differences(some, Drawn({.title = "k", .unit = "1/" + std::string(200, 'm')}), 0, 300), 0u);
  EXPECT_GT(Differences(some, Drawn({.title = "k", .unit = "1/" + std::string(4, 'm')}), 0, 60), 20u);
}

TEST(LegendTest, TheBarGoesFromBlueToRed) {
  const Image image = Drawn({.title = "k"});
  const int x = 400 - LegendWidth(400, 300) + LegendWidth(400, 300) / 7;
  int first_red = -1, last_blue = -1;
  for (int y = 0; y < 300; ++y) {
    if (image.at(x, y).red > image.at(x, y).blue + 0.5f && first_red < 0) first_red = y;
    if (image.at(x, y).blue > image.at(x, y).red + 0.5f) last_blue = y;
  }
  EXPECT_GT(first_red, 0);
  EXPECT_GT(last_blue, first_red + 80);
}

TEST(LegendTest, ShowsWhatLiesBeyondTheScaleAndWhatIsMissing) {
  const Image plain = Drawn({.title = "k"});
  EXPECT_GT(Differences(plain, Drawn({.title = "k", .has_above = true}), 0, 60), 20u);
  EXPECT_EQ(Differences(plain, Drawn({.title = "k", .has_above = true}), 250, 300), 0u);
  EXPECT_GT(Differences(plain, Drawn({.title = "k", .has_below = true}), 100, 300), 20u);
  EXPECT_GT(Differences(plain, Drawn({.title = "k", .has_missing = true}), 100, 300), 50u);
  EXPECT_GT(Differences(plain, Drawn({.title = "k", .unit = "1/mm"}), 0, 60), 20u);
}

TEST(LegendTest, IsTheSameEachTime) {
  EXPECT_EQ(Differences(Drawn({.title = "Kr\u00fcmmung"}), Drawn({.title = "Kr\u00fcmmung"}), 0, 300), 0u);
}

TEST(LegendTest, GivesWayInSmallPictures) {
  EXPECT_EQ(LegendWidth(64, 64), 0);
  EXPECT_EQ(LegendWidth(4096, 64), 0);
  EXPECT_EQ(LegendWidth(64, 4096), 0);
  EXPECT_GT(LegendWidth(320, 240), 0);
}

TEST(LegendTest, HasRoomInEveryPicture) {
  const LegendText text{.title = "a title that needs many lines in a small picture because it is long",
                        .unit = "1/length unit",
                        .has_missing = true,
                        .has_below = true,
                        .has_above = true};
  for (int width = 64; width <= 1000; width += 117) {
    for (int height = 64; height <= 1000; height += 117) Drawn(text, width, height);
  }
}

}  // namespace
}  // namespace curv
