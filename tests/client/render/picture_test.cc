#include "client/render/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <utility>

#include "client/render/legend.h"
#include "client/surfaces/surface.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

bool IsWhite(const Color& color) { return color.red == 1.0f && color.green == 1.0f && color.blue == 1.0f; }

Image Draw(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, const std::vector<double>& values,
           std::string_view view = "front") {
  PictureOptions options{.width = 400, .height = 300, .view = *MakeView(view, 'z')};
  const std::vector<Layer> layers = {{.values = values, .scale = ColorScale(-1, 1)}};
  absl::StatusOr<Image> image = DrawPicture(positions, normals, layers, options);
  EXPECT_TRUE(image.ok()) << image.status();
  return *image;
}

// The place of the cloud, beside the scale bar, and its size are as DrawPicture's framing makes them.
const int kCloudWidth = 400 - LegendWidth(400, 300);

TEST(PictureTest, ASphereLooksClosed) {
  const auto sphere = *MakeSurface("sphere");
  const std::vector<Vec3> points = *SampleEvenly(*sphere, 3000, 0);
  const Image image = Draw(points, points, std::vector<double>(points.size(), 1.0));
  const double radius = 0.45 * std::min(kCloudWidth, 300);  // with a margin of 0.05
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < kCloudWidth; ++x) {
      const double distance = std::hypot(x + 0.5 - 0.5 * kCloudWidth, y + 0.5 - 150.0) / radius;
      // Discs may stand out at the rim by their tilt.
      if (distance < 0.98) {
        EXPECT_GT(image.at(x, y).red, image.at(x, y).blue) << "hole at " << x << " " << y;
      } else if (distance > 1.04) {
        EXPECT_TRUE(IsWhite(image.at(x, y))) << x << " " << y;
      }
    }
  }
}

TEST(PictureTest, TheFrontHidesTheBack) {
  // Seen from -y: the red layer is nearer.
  std::vector<Vec3> positions, normals;
  std::vector<double> values;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      for (const double y : {-1.0, 1.0}) {
        positions.push_back({0.1 * i, y, 0.1 * j});
        normals.push_back({0, y, 0});
        values.push_back(-y);
      }
    }
  }
  const Image front = Draw(positions, normals, values, "front");
  EXPECT_GT(front.at(kCloudWidth / 2, 150).red, front.at(kCloudWidth / 2, 150).blue);
  const Image back = Draw(positions, normals, values, "back");
  EXPECT_LT(back.at(kCloudWidth / 2, 150).red, back.at(kCloudWidth / 2, 150).blue);
}

TEST(PictureTest, UpIsUpAndRightIsRight) {
  // From the front, +x is to the right and +z upward.
  std::vector<Vec3> positions;
  std::vector<double> values;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      positions.push_back({0.1 * i, 0, 0.1 * j});
      values.push_back(i > 5 && j > 5 ? 1 : -1);
    }
  }
  const Image image = Draw(positions, std::vector<Vec3>(positions.size(), {0, -1, 0}), values);
  double red_x = 0, red_y = 0, count = 0;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < kCloudWidth; ++x) {
      if (image.at(x, y).red <= image.at(x, y).blue + 0.3f) continue;
      red_x += x;
      red_y += y;
      ++count;
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_GT(red_x / count, 0.6 * kCloudWidth);
  EXPECT_LT(red_y / count, 120);
}

TEST(PictureTest, SurvivesOddClouds) {
  const double nan = NAN, inf = INFINITY;
  Draw({{1, 2, 3}}, {{0, 0, 0}}, {nan});
  Draw(std::vector<Vec3>(20, {5e6, 5e6, 1}), std::vector<Vec3>(20, {nan, 0, 0}), std::vector<double>(20, inf));
  Draw({{0, 0, 0}, {nan, 0, 0}, {1e-30, 0, 0}, {1e30, 0, 0}}, std::vector<Vec3>(4, {1, 0, 0}), {1, 2, 3, 4});
  PictureOptions options{.view = *MakeView("front", 'z')};
  EXPECT_THAT(DrawPicture({{inf, 0, 0}}, {{0, 0, 1}}, {{.values = {1}}}, options).status().message(),
              HasSubstr("no point"));
  EXPECT_FALSE(DrawPicture({}, {}, {{}}, options).ok());
}

// A square of points that faces the front.
std::vector<Vec3> Square(int side, double size) {
  std::vector<Vec3> positions;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) positions.push_back({size * i / side, 0, size * j / side});
  }
  return positions;
}

TEST(PictureTest, DiscsStayOutOfTheLegend) {
  // Few points have large discs. Those of positive values are red, and so is the upper half of the scale only.
  for (const int side : {2, 3, 5}) {
    std::vector<Vec3> positions = Square(side, 1.0);
    for (Vec3& position : positions) position.x *= 3.0;
    const std::vector<Vec3> normals(positions.size(), Vec3{0, -1, 0});
    const Image red = Draw(positions, normals, std::vector<double>(positions.size(), 1.0));
    const Image blue = Draw(positions, normals, std::vector<double>(positions.size(), -1.0));
    for (int y = 0; y < 300; ++y) {
      for (int x = kCloudWidth; x < 400; ++x) ASSERT_EQ(red.at(x, y).red, blue.at(x, y).red) << x << " " << y;
      ASSERT_TRUE(IsWhite(red.at(0, y)) && IsWhite(red.at(kCloudWidth - 1, y))) << "a disc is cut off";
    }
  }
}

TEST(PictureTest, LonelyPointsAreSeen) {
  const std::vector<Vec3> clouds[] = {
      {{1, 2, 3}},                                           // one point
      std::vector<Vec3>(20, {5e6, 5e6, 1}),                  // all at one place
      {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}},                     // a line seen from its end
      {{1e300, 1e300, -1e300}},                              //
      {{0, 0, 0}},                                           //
      {{5e-324, 0, 0}},                                      //
      std::vector<Vec3>{{-1.7e308, 0, 0}, {1.7e308, 0, 0}},  // farther apart than the largest number
  };
  for (const std::vector<Vec3>& positions : clouds) {
    const std::vector<Vec3> normals(positions.size(), Vec3{0, -1, 0});
    const Image image = Draw(positions, normals, std::vector<double>(positions.size(), 1.0));
    int red = 0;
    for (int y = 0; y < 300; ++y) {
      for (int x = 0; x < kCloudWidth; ++x) red += image.at(x, y).red > image.at(x, y).blue + 0.3f ? 1 : 0;
    }
    EXPECT_GT(red, 300 * kCloudWidth / 200) << positions[0].x;
    EXPECT_LT(red, 300 * kCloudWidth / 4) << positions[0].x;
  }
}

TEST(PictureTest, TheLengthUnitChangesNothing) {
  const auto goursat = *MakeSurface("goursat");
  const std::vector<Vec3> positions = *SampleEvenly(*goursat, 500, 0);
  const std::vector<double> values(positions.size(), 0.5);
  const Image expected = Draw(positions, positions, values, "three-quarter");
  for (const int exponent : {-1000, -300, 300, 1000}) {
    std::vector<Vec3> scaled = positions;
    for (Vec3& position : scaled) position = std::ldexp(1.0, exponent) * position;
    const Image image = Draw(scaled, positions, values, "three-quarter");
    for (size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(image.pixels[i].red, expected.pixels[i].red) << exponent;
  }
}

TEST(PictureTest, FarFromTheOriginTheFrontStillHidesTheBack) {
  // In floats, a depth of 5e6 sizes of the cloud has no room for the cloud itself.
  std::vector<Vec3> positions = Square(30, 1.0);
  std::vector<double> values(positions.size(), 1.0);
  for (size_t i = 0, count = positions.size(); i < count; ++i) {
    positions.push_back(positions[i] + Vec3{0, 1, 0});
    values.push_back(-1.0);
  }
  for (Vec3& position : positions) position += {0, 5e7, 0};
  const Image image = Draw(positions, std::vector<Vec3>(positions.size(), {0, -1, 0}), values);
  EXPECT_GT(image.at(kCloudWidth / 2, 150).red, image.at(kCloudWidth / 2, 150).blue + 0.3f);
}

TEST(PictureTest, TallPicturesHaveAMarginOfTheirWidth) {
  const std::vector<Vec3> positions = Square(50, 1.0);
  PictureOptions options{.width = 64, .height = 1024, .view = *MakeView("front", 'z')};
  const std::vector<double> values(positions.size(), 1.0);
  const absl::StatusOr<Image> image =
      DrawPicture(positions, std::vector<Vec3>(positions.size(), {0, -1, 0}), {{.values = values}}, options);
  ASSERT_TRUE(image.ok()) << image.status();
  int drawn = 0;
  for (int x = 0; x < 64; ++x) drawn += IsWhite(image->at(x, 512)) ? 0 : 1;
  EXPECT_NEAR(drawn, 0.9 * 64, 2);
}

TEST(PictureTest, SmallPicturesAreOfTheCloudAlone) {
  const auto sphere = *MakeSurface("sphere");
  const std::vector<Vec3> points = *SampleEvenly(*sphere, 500, 0);
  PictureOptions options{.width = 64, .height = 64, .view = *MakeView("front", 'z')};
  const absl::StatusOr<Image> image = DrawPicture(points, points, {{.values = std::vector<double>(500, 1.0)}}, options);
  ASSERT_TRUE(image.ok()) << image.status();
  for (int x = 8; x < 56; ++x) EXPECT_FALSE(IsWhite(image->at(x, 32))) << x;
}

TEST(PictureTest, PanelsShowTheirOwnValuesOfOneCloud) {
  const std::vector<Vec3> positions = Square(30, 1.0);
  const std::vector<Vec3> normals(positions.size(), Vec3{0, -1, 0});
  std::vector<Layer> layers;
  for (const double value : {1.0, -1.0, 1.0}) {
    layers.push_back({.values = std::vector<double>(positions.size(), value), .scale = ColorScale(-1, 1)});
  }
  const PictureOptions options{.width = 800, .height = 600, .view = *MakeView("front", 'z')};
  const absl::StatusOr<Image> sheet = DrawPicture(positions, normals, layers, options);
  ASSERT_TRUE(sheet.ok()) << sheet.status();
  // Each panel is the picture of its layer.
  for (int panel = 0; panel < 4; ++panel) {
    const int left = panel % 2 * 400, top = panel / 2 * 300;
    const std::vector<double> values(positions.size(), panel == 1 ? -1.0 : 1.0);
    const Image expected = panel == 3 ? Image(400, 300, {1, 1, 1}) : Draw(positions, normals, values);
    for (int y = 0; y < 300; ++y) {
      for (int x = 0; x < 400; ++x) {
        ASSERT_EQ(sheet->at(left + x, top + y).red, expected.at(x, y).red) << panel << ": " << x << " " << y;
      }
    }
  }
}

TEST(PictureTest, RefusesPanelsThatAreTooSmall) {
  const std::vector<Layer> layers(16, Layer{.values = {1}});
  const PictureOptions options{.width = 200, .height = 200, .view = *MakeView("front", 'z')};
  EXPECT_THAT(DrawPicture({{0, 0, 0}}, {{0, 0, 1}}, layers, options).status().message(),
              HasSubstr("16 panels of a picture of 200x200 would be of 50x50 pixels: each side must be at least 64"));
}

TEST(PictureTest, ArrangesPanelsByTheShapeOfThePicture) {
  const auto grid = [](int panels, int width, int height) {
    const PanelGrid grid = ArrangePanels(panels, width, height);
    return std::pair(grid.columns, grid.rows);
  };
  EXPECT_EQ(grid(1, 1200, 900), std::pair(1, 1));
  EXPECT_EQ(grid(4, 1200, 900), std::pair(2, 2));
  EXPECT_EQ(grid(4, 4000, 900), std::pair(4, 1));
  EXPECT_EQ(grid(4, 600, 2400), std::pair(1, 4));
  EXPECT_EQ(grid(2, 1600, 600), std::pair(2, 1));
}

TEST(CameraTest, ViewsAreRightHanded) {
  for (const char* name : {"three-quarter", "front", "back", "left", "right", "top", "bottom", "12.5:-30"}) {
    for (const char up : {'y', 'z'}) {
      const absl::StatusOr<View> view = MakeView(name, up);
      ASSERT_TRUE(view.ok()) << view.status();
      EXPECT_LT(Norm(Cross(view->right, view->up) - view->toward), 1e-12) << name;
    }
  }
  EXPECT_NEAR(MakeView("front", 'z')->toward.y, -1, 1e-12);
  EXPECT_NEAR(MakeView("front", 'y')->toward.z, 1, 1e-12);
  EXPECT_NEAR(MakeView("top", 'y')->toward.y, 1, 1e-12);
}

TEST(CameraTest, RefusesOtherViews) {
  for (const char* name : {"", "side", "10", "10:", ":10", "10:91", "nan:0", "1:2:3"}) {
    EXPECT_THAT(MakeView(name, 'z').status().message(), HasSubstr("AZIMUTH:ELEVATION")) << name;
  }
}

TEST(ImageTest, PngComesBack) {
  Image image(3, 2, {1, 0.5f, 0});
  image.at(2, 1) = {0, 0, 1};
  const std::string png = EncodePng(image);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&header, png.data(), png.size()), 0);
  header.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> bytes(PNG_IMAGE_SIZE(header));
  ASSERT_NE(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr), 0);
  EXPECT_EQ(header.width, 3u);
  EXPECT_EQ(header.height, 2u);
  EXPECT_EQ((std::vector<uint8_t>{bytes.begin(), bytes.begin() + 3}), (std::vector<uint8_t>{255, 128, 0}));
  EXPECT_EQ((std::vector<uint8_t>{bytes.end() - 3, bytes.end()}), (std::vector<uint8_t>{0, 0, 255}));
}

}  // namespace
}  // namespace curv
