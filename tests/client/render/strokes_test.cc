#include "client/render/strokes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace curv {
namespace {

constexpr int kSide = 100;
constexpr double kLetter = 12.0;
constexpr Color kRed{1, 0, 0};

struct Drawn {
  Image before;
  Image after;

  // The dark line of a stroke; its casing is light.
  bool IsDark(int x, int y) const { return after.at(x, y).red < 0.6f * before.at(x, y).red; }
};

// A square of red splats, with strokes in one direction.
Drawn Draw(const Vec3& direction, const Vec3& normal = {0, 0, 1}) {
  std::vector<Splat> splats;
  for (int y = 2; y < kSide; y += 4) {
    for (int x = 2; x < kSide; x += 4) splats.push_back({{1.0 * x, 1.0 * y, 0}, normal, 6.0, kRed});
  }
  Image before(kSide, kSide, {1, 1, 1});
  const std::vector<float> depths = DrawSplats(splats, 1, before);
  Drawn drawn{before, before};
  DrawStrokes(splats, {{.name = "d", .directions = std::vector<Vec3>(splats.size(), direction)}}, depths, kLetter,
              drawn.after);
  return drawn;
}

// How many pixels are dark, and how many of them have a dark neighbor to the right, and below.
struct Dark {
  int all = 0, beside = 0, below = 0;
};

Dark CountDark(const Drawn& drawn) {
  Dark dark;
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      if (!drawn.IsDark(x, y)) continue;
      ++dark.all;
      dark.beside += drawn.IsDark(x + 1, y) ? 1 : 0;
      dark.below += drawn.IsDark(x, y + 1) ? 1 : 0;
    }
  }
  return dark;
}

TEST(StrokesTest, LieAlongTheDirection) {
  const Dark across = CountDark(Draw({1, 0, 0})), upright = CountDark(Draw({0, 3, 0}));
  EXPECT_GT(across.all, 100);
  // A line that lies between two rows of pixels darkens both: half of its pixels have one below.
  EXPECT_GT(across.beside, 1.5 * across.below);
  EXPECT_GT(upright.below, 1.5 * upright.beside);
}

TEST(StrokesTest, AreAsFarApartAsLettersAre) {
  // 100 pixels have 5 squares of 1.7 letters on a side; strokes are 1.25 letters long, and one or two pixels wide.
  const int dark = CountDark(Draw({1, 0, 0})).all;
  EXPECT_GT(dark, 25 * 15);
  EXPECT_LT(dark, 25 * 15 * 2.5);
}

TEST(StrokesTest, TheSignShowsInNothing) {
  const Image one = Draw({1, 2, 0}).after, other = Draw({-1, -2, 0}).after;
  // A level of the 256 is what cairo rounds to.
  for (size_t i = 0; i < one.pixels.size(); ++i) ASSERT_NEAR(one.pixels[i].red, other.pixels[i].red, 1.1 / 255);
}

TEST(StrokesTest, LeaveOutWhatHasNoDirectionOrIsSeenFromItsEdge) {
  EXPECT_EQ(CountDark(Draw({0, 0, 0})).all, 0);
  EXPECT_EQ(CountDark(Draw({std::numeric_limits<double>::quiet_NaN(), 0, 0})).all, 0);
  EXPECT_EQ(CountDark(Draw({0, 0, 1}, {1, 0, 0})).all, 0);
}

TEST(StrokesTest, LeaveOutWhatIsHidden) {
  // The far layer alone has directions.
  std::vector<Splat> splats;
  std::vector<Vec3> directions;
  for (const double z : {0.0, -50.0}) {
    for (int y = 2; y < kSide; y += 4) {
      for (int x = 2; x < kSide; x += 4) {
        splats.push_back({{1.0 * x, 1.0 * y, z}, {0, 0, 1}, 6.0, kRed});
        directions.push_back(z < 0 ? Vec3{1, 0, 0} : Vec3{});
      }
    }
  }
  Image before(kSide, kSide, {1, 1, 1});
  const std::vector<float> depths = DrawSplats(splats, 1, before);
  Drawn drawn{before, before};
  DrawStrokes(splats, {{"d", directions}}, depths, kLetter, drawn.after);
  EXPECT_EQ(CountDark(drawn).all, 0);
}

}  // namespace
}  // namespace curv
