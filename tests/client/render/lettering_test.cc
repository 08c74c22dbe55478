#include "client/render/lettering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "client/render/canvas.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

constexpr Color kPaper{1, 1, 1};
// Leaves the order of what follows to whoever wrote it, whatever language it is.
const std::string kAsWritten = "\u202d";

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
  TextBlock(text, 16, canvas.cairo()).Draw(10, 30);
  return image;
}

std::vector<float> PixelsOf(const std::string& text) {
  std::vector<float> pixels;
  for (const Color& color : Written(text).pixels) pixels.push_back(color.green);
  return pixels;
}

class LetteringTest : public ::testing::Test {
 protected:
  double Width(const std::string& text) { return TextBlock(text, 16, canvas_.cairo()).width(); }
  TextBlock Lines(const std::string& text, double width, int max_lines) {
    return TextBlock(text, 16, width, max_lines, canvas_.cairo());
  }
  cairo_t* cairo() { return canvas_.cairo(); }

  Image image_{400, 200, kPaper};
  Canvas canvas_{0, image_};
};

TEST_F(LetteringTest, AFontIsInstalled) { EXPECT_TRUE(CheckFonts().ok()) << CheckFonts(); }

TEST_F(LetteringTest, DrawsWithinItsWidth) {
  const int right = static_cast<int>(10 + Width("0.25") + 2);
  const Image image = Written("0.25");
  EXPECT_GT(DrawnPixels(image, 8, right, 14, 32), 20u);
  EXPECT_EQ(DrawnPixels(image, 8, right, 14, 32), DrawnPixels(image, 0, 200, 0, 40));
}

// The strokes that letters were once drawn with had two capitals.
TEST_F(LetteringTest, EveryLetterIsDrawnAndDiffers) {
  std::vector<std::vector<float>> seen;
  for (const char* letter :
       {"A", "B", "I", "J", "Q", "Z", "a", "k", "z", "%", "\u00e4", "\u0416", "\u03ba", "\u00b2", "\u2081", "\u2212"}) {
    std::vector<float> pixels = PixelsOf(letter);
    EXPECT_GT(DrawnPixels(Written(letter), 0, 200, 0, 40), 3u) << letter;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), pixels), 0) << letter;
    seen.push_back(std::move(pixels));
  }
}

// Beh, beh, beh: joined, or kept apart by zero-width non-joiners, as they stand alone.
TEST_F(LetteringTest, JoinsArabicLetters) {
  const std::string joined = "\u0628\u0628\u0628", apart = "\u0628\u200c\u0628\u200c\u0628";
  EXPECT_NEAR(Width(apart), 3.0 * Width("\u0628"), 0.1);
  EXPECT_LT(Width(joined), 0.8 * Width(apart));
  EXPECT_NE(PixelsOf(joined), PixelsOf(apart));
}

// "Curvature 12" in Hebrew: the word from the right, the digits left of it and as ever.
TEST_F(LetteringTest, WritesHebrewFromTheRightAndItsDigitsFromTheLeft) {
  EXPECT_EQ(PixelsOf("\u05e2\u05e7\u05d5\u05dd 12"), PixelsOf(kAsWritten + "12 \u05dd\u05d5\u05e7\u05e2"));
  EXPECT_NE(PixelsOf("\u05e2\u05e7\u05d5\u05dd 12"), PixelsOf(kAsWritten + "\u05e2\u05e7\u05d5\u05dd 12"));
  EXPECT_EQ(PixelsOf("H (\u05d0\u05d1)"), PixelsOf(kAsWritten + "H (\u05d1\u05d0)"));
}

// The vowel i stands before the consonant that it is spoken after; r and a consonant become one letter.
TEST_F(LetteringTest, StacksDevanagariLetters) {
  const std::string ki = "\u0915\u093f", kra = "\u0915\u094d\u0930";
  if (!LetteringProblem(ki).empty()) GTEST_SKIP() << LetteringProblem(ki);
  EXPECT_LT(Width(kra), 0.8 * (Width("\u0915") + Width("\u0930")));
  // Where the two stand apart the vowel has no consonant and hangs on a dotted circle.
  EXPECT_LT(Width(ki), Width("\u0915\u200b\u093f"));
}

TEST_F(LetteringTest, SeveralLanguagesShareATitle) {
  const std::string both = "H \u05e2\u05e7\u05d5\u05dd \u0627\u0646\u062d\u0646\u0627\u0621 \u043a\u0440";
  EXPECT_EQ(LetteringProblem(both), "");
  EXPECT_GT(Width(both), Width("H \u05e2\u05e7\u05d5\u05dd"));
}

TEST_F(LetteringTest, NamesCharactersThatNoFontHas) {
  EXPECT_THAT(LetteringProblem("k \U0010fff0a"), HasSubstr(": \U0010fff0 will be boxes"));
  EXPECT_EQ(LetteringProblem("k\u2081 = 1/mm \u2212 \u03ba"), "");
  EXPECT_EQ(LetteringProblem(""), "");
}

TEST_F(LetteringTest, BytesThatAreNoTextStopNothing) {
  for (const char* text : {"\xff", "\xc3", "\xed\xa0\x80", "\xf7\xbf\xbf\xbf", "a\x80z", "\x01\n\x7f", "a\u2029b"}) {
    const TextBlock block(text, 16, cairo());
    block.Draw(0, 20);
    EXPECT_GT(block.width(), 0.0);
    EXPECT_EQ(block.line_count(), 1);
    EXPECT_EQ(cairo_status(cairo()), CAIRO_STATUS_SUCCESS);
  }
}

TEST_F(LetteringTest, BreaksLinesAtBlanks) {
  const double width = Width("principal curvature") + 0.1;
  const TextBlock block = Lines("principal curvature of it", width, 4);
  EXPECT_EQ(block.line_count(), 2);
  EXPECT_NEAR(block.width(), width, 0.2);
  EXPECT_EQ(Lines("principal curvature", width, 4).line_count(), 1);
}

TEST_F(LetteringTest, BreaksLongWordsAnywhere) {
  EXPECT_EQ(Lines("\u00e4\u00e4\u00e4\u00e4\u00e4\u00e4", Width("\u00e4\u00e4\u00e4\u00e4") + 0.1, 4).line_count(), 2);
  EXPECT_EQ(Lines("mmm", 1.0, 4).line_count(), 3);
}

TEST_F(LetteringTest, EndsWithAnEllipsisWhatHasNoRoom) {
  const double width = Width("mmmm");
  const TextBlock block = Lines("mmmmmmmmmmmmmmmm", width, 2);
  EXPECT_EQ(block.line_count(), 2);
  EXPECT_LE(block.width(), width);
  // Nothing shows how much was left out, but that something was: the ellipsis is narrower than the last letter.
  EXPECT_EQ(Lines("mmmmmmmmm", width, 2).width(), block.width());
}

// Lines read from the right end below each other, and those read from the left begin so.
TEST_F(LetteringTest, LinesEndWhereTheirReadersBegin) {
  for (const bool from_right : {false, true}) {
    Image image(200, 80, kPaper);
    const std::string letter = from_right ? "\u05dd" : "H";
    double width = 0.0;
    {
      Canvas canvas(0, image);
      const TextBlock block(letter + letter + letter + letter + " " + letter, 16,
                            Width(letter + letter + letter + letter) + 0.1, 2, canvas.cairo());
      ASSERT_EQ(block.line_count(), 2);
      width = block.width();
      block.Draw(10, 30, 30);
    }
    const int middle = static_cast<int>(10 + width / 2), right = static_cast<int>(10 + width) + 2;
    EXPECT_EQ(DrawnPixels(image, middle, right, 40, 70) > 0, from_right);
    EXPECT_EQ(DrawnPixels(image, 8, middle, 40, 70) > 0, !from_right);
  }
}

}  // namespace
}  // namespace curv
