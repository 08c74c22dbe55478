#include "core/estimators/normal_curvature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace curvd::testing {
namespace {

// A saddle in the plane z = 0, d1 and d2 turned by `angle` from the axes.
PointCurvature Saddle(double angle = 0.0) {
  PointCurvature point{};
  point.k1 = -1.0f;
  point.k2 = 3.0f;
  point.d1 = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0f};
  point.d2 = {static_cast<float>(-std::sin(angle)), static_cast<float>(std::cos(angle)), 0.0f};
  point.status = PointStatus::kOk;
  return point;
}

TEST(NormalCurvatureTest, FollowsEulersTheorem) {
  for (const double turned : {0.0, 0.4, 2.0}) {
    for (const double angle : {0.0, 0.3, 0.8, 1.5, 3.0}) {
      const Direction direction = DirectionOf({std::cos(angle + turned), std::sin(angle + turned), 0.0});
      const double cosine = std::cos(angle), sine = std::sin(angle);
      EXPECT_NEAR(NormalCurvature(Saddle(turned), direction), -cosine * cosine + 3.0 * sine * sine, 1e-6) << angle;
    }
  }
}

TEST(NormalCurvatureTest, ProjectsTheDirectionWhateverItsLength) {
  for (const double scale : {1e-300, 1e-3, 1.0, 1e300}) {
    const Direction steep = DirectionOf({0.01 * scale, 0.0, scale});
    EXPECT_NEAR(NormalCurvature(Saddle(), steep), -1.0, 1e-6) << scale;
  }
  EXPECT_EQ(NormalCurvature(Saddle(), DirectionOf({1, 2, 3})), NormalCurvature(Saddle(), DirectionOf({-1, -2, -3})));
}

TEST(NormalCurvatureTest, IsNaNWhereTheTangentPlaneHasNoSuchDirection) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(NormalCurvature(Saddle(), DirectionOf({0, 0, -2}))));
  EXPECT_TRUE(std::isnan(NormalCurvature(Saddle(), DirectionOf({1e-7, 0, 1})))) << "rounding would decide";
  EXPECT_TRUE(std::isnan(NormalCurvature(Saddle(), DirectionOf({0, 0, 0}))));
  EXPECT_TRUE(std::isnan(NormalCurvature(Saddle(), DirectionOf({std::nan(""), 1, 0}))));
  EXPECT_TRUE(std::isnan(NormalCurvature(Saddle(), DirectionOf({kInfinity, -kInfinity, 0}))));
  EXPECT_TRUE(std::isnan(NormalCurvature(UndefinedCurvature(PointStatus::kSingularFit), DirectionOf({1, 0, 0}))));
}

TEST(NormalCurvatureTest, TakesOneDirectionOrOneForEachPoint) {
  const std::vector<PointCurvature> points = {Saddle(), Saddle()};
  const std::vector<Direction> each = {DirectionOf({1, 0, 0}), DirectionOf({0, 1, 0})};
  std::vector<char> bytes(1 + 2 * sizeof(float));
  float values[2];
  WriteNormalCurvatures(points, each, bytes.data() + 1);  // not aligned
  std::memcpy(values, bytes.data() + 1, sizeof(values));
  EXPECT_EQ(values[0], -1.0f);
  EXPECT_EQ(values[1], 3.0f);
  WriteNormalCurvatures(points, std::span(each).first(1), bytes.data() + 1);
  std::memcpy(values, bytes.data() + 1, sizeof(values));
  EXPECT_EQ(values[1], -1.0f);
}

}  // namespace
}  // namespace curvd::testing
