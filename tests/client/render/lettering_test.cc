#include "client/render/lettering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "client/render/canvas.h"

namespace curv {
namespace {

using ::testing::ElementsAre;

constexpr Color kPaper{1, 1, 1};

size_t DrawnPixels(const Image& image, int left, int right, int top, int bottom) {
  size_t drawn = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) drawn += image.at(x, y).green < 0.9f ? 1 : 0;
  }
  return drawn;
}

Image Written(const std::string& text) {
  Image image(200, 40, kPaper);
  Canvas canvas(0, image);
  SelectFont(text, 16, canvas.cairo());
  DrawText(text, 10, 30, canvas.cairo());
  return image;
}

class LetteringTest : public ::testing::Test {
 protected:
  LetteringTest() : image_(400, 40, kPaper), canvas_(0, image_) { SelectFont("a", 16, canvas_.cairo()); }
  cairo_t* cairo() { return canvas_.cairo(); }

  Image image_;
  Canvas canvas_;
};

TEST_F(LetteringTest, AFontIsInstalled) { EXPECT_TRUE(CheckFonts().ok()) << CheckFonts(); }

TEST_F(LetteringTest, DrawsWithinItsWidth) {
  Image image(200, 40, kPaper);
  double width = 0;
  {
    Canvas canvas(0, image);
    SelectFont("0.25", 16, canvas.cairo());
    DrawText("0.25", 10, 30, canvas.cairo());
    width = TextWidth("0.25", canvas.cairo());
  }
  const int right = static_cast<int>(10 + width + 2);
  EXPECT_GT(DrawnPixels(image, 8, right, 14, 32), 20u);
  EXPECT_EQ(DrawnPixels(image, 8, right, 14, 32), DrawnPixels(image, 0, 200, 0, 40));
}

// The strokes that letters were once drawn with had two capitals.
TEST_F(LetteringTest, EveryLetterIsDrawnAndDiffers) {
  std::vector<std::vector<float>> seen;
  for (const char* letter :
       {"A", "B", "I", "J", "Q", "Z", "a", "k", "z", "%", "\u00e4", "\u0416", "\u03ba", "\u00b2", "\u2081", "\u2212"}) {
    const Image image = Written(letter);
    std::vector<float> pixels;
    for (const Color& color : image.pixels) pixels.push_back(color.green);
    EXPECT_GT(DrawnPixels(image, 0, 200, 0, 40), 3u) << letter;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), pixels), 0) << letter;
    seen.push_back(std::move(pixels));
  }
}

TEST_F(LetteringTest, BytesThatAreNoTextStopNothing) {
  for (const char* text : {"\xff", "\xc3", "\xed\xa0\x80", "\xf7\xbf\xbf\xbf", "a\x80z", "\x01\n\x7f"}) {
    DrawText(text, 0, 20, cairo());
    EXPECT_GT(TextWidth(text, cairo()), 0.0);
    EXPECT_EQ(cairo_status(cairo()), CAIRO_STATUS_SUCCESS);
  }
}

TEST_F(LetteringTest, BreaksLinesAtBlanks) {
  const double width = TextWidth("principal curvature", cairo());
  EXPECT_THAT(BreakLines("principal curvature of it", width, 4, cairo()), ElementsAre("principal curvature", "of it"));
  EXPECT_THAT(BreakLines("principal curvature", width, 4, cairo()), ElementsAre("principal curvature"));
  EXPECT_THAT(BreakLines("", width, 4, cairo()), ElementsAre());
}

TEST_F(LetteringTest, BreaksLongWordsAnywhere) {
  const double width = TextWidth("\u00e4\u00e4\u00e4\u00e4", cairo());
  EXPECT_THAT(BreakLines("\u00e4\u00e4\u00e4\u00e4\u00e4\u00e4", width, 4, cairo()),
              ElementsAre("\u00e4\u00e4\u00e4\u00e4", "\u00e4\u00e4"));
  EXPECT_THAT(BreakLines("mmm", 1.0, 4, cairo()), ElementsAre("m", "m", "m"));
}

TEST_F(LetteringTest, EndsWithAnEllipsisWhatHasNoRoom) {
  const double width = TextWidth("mmmm", cairo());
  const std::vector<std::string> lines = BreakLines("mmmmmmmmmmmmmmmm", width, 2, cairo());
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[1], ::testing::EndsWith("m\u2026"));
  EXPECT_LE(TextWidth(lines[1], cairo()), width);
}

}  // namespace
}  // namespace curv
