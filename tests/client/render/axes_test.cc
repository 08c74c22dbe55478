#include "client/render/axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "client/render/canvas.h"

namespace curv {
namespace {

constexpr int kSize = 10, kMiddle = 40;

Image Drawn(std::string_view view) {
  Image image(2 * kMiddle, 2 * kMiddle, {1, 1, 1});
  Canvas canvas(0, image);
  DrawAxes(*MakeView(view, 'z'), kMiddle, kMiddle, kSize, canvas.cairo());
  return image;
}

// How dark the darkest pixel around a place is, which is given in letter sizes from the middle, y upward.
float Darkest(const Image& image, double x, double y) {
  float darkest = 0.0f;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      const Color& color =
          image.at(kMiddle + static_cast<int>(x * kSize) + dx, kMiddle - static_cast<int>(y * kSize) + dy);
      darkest = std::max(darkest, 1.0f - color.green);
    }
  }
  return darkest;
}

TEST(AxesTest, PointWhereTheViewTurnsThem) {
  const Image front = Drawn("front");  // x to the right, z up, y away
  EXPECT_GT(Darkest(front, 1.0, 0.0), 0.35f);
  EXPECT_GT(Darkest(front, 0.0, 1.0), 0.35f);
  EXPECT_EQ(Darkest(front, -1.3, 0.0), 0.0f);
  EXPECT_EQ(Darkest(front, 0.0, -1.3), 0.0f);
  const Image back = Drawn("back");  // x to the left
  EXPECT_GT(Darkest(back, -1.0, 0.0), 0.35f);
  EXPECT_EQ(Darkest(back, 1.3, 0.0), 0.0f);
}

TEST(AxesTest, AnAxisSeenFromItsEndIsARing) {
  // In the middle between ring and dot, there is paper if the axis points toward the viewer, a cross if not.
  EXPECT_GT(Darkest(Drawn("back"), -0.3, -0.1), 0.3f);
  EXPECT_GT(Darkest(Drawn("front"), -0.3, -0.1), 0.2f);
}

TEST(AxesTest, FarAxesAreFaint) {
  const Image image = Drawn("35:25");  // y points away, to the upper right
  EXPECT_GT(Darkest(image, 0.5, 0.3), 0.1f);
  EXPECT_LT(Darkest(image, 0.5, 0.3), 0.4f);
}

TEST(AxesTest, StayWithinTheirReach) {
  for (const char* view : {"three-quarter", "front", "back", "left", "right", "top", "bottom", "200:-40", "1:1"}) {
    const Image image = Drawn(view);
    for (int y = 0; y < 2 * kMiddle; ++y) {
      for (int x = 0; x < 2 * kMiddle; ++x) {
        if (std::max(std::abs(x - kMiddle), std::abs(y - kMiddle)) > 2.8 * kSize) {
          EXPECT_EQ(image.at(x, y).green, 1.0f) << view;
        }
      }
    }
  }
}

}  // namespace
}  // namespace curv
