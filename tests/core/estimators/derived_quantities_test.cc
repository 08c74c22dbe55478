#include "core/estimators/derived_quantities.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace curvd::testing {
namespace {

PointCurvature WithPrincipals(float k1, float k2) {
  PointCurvature point = UndefinedCurvature(PointStatus::kOk);
  point.k1 = k1;
  point.k2 = k2;
  return point;
}

TEST(DerivedQuantitiesTest, TheShapeIndexNamesTheShape) {
  EXPECT_FLOAT_EQ(ShapeIndex(WithPrincipals(2.0f, 2.0f)), 1.0f) << "a cap, as a ball from outside";
  EXPECT_FLOAT_EQ(ShapeIndex(WithPrincipals(0.0f, 3.0f)), 0.5f) << "a ridge";
  EXPECT_FLOAT_EQ(ShapeIndex(WithPrincipals(-3.0f, 3.0f)), 0.0f) << "a saddle";
  EXPECT_FLOAT_EQ(ShapeIndex(WithPrincipals(-3.0f, 0.0f)), -0.5f) << "a rut";
  EXPECT_FLOAT_EQ(ShapeIndex(WithPrincipals(-2.0f, -2.0f)), -1.0f) << "a cup";
}

TEST(DerivedQuantitiesTest, TheShapeIndexDoesNotDependOnTheSize) {
  const float small = ShapeIndex(WithPrincipals(1e-30f, 2e-30f)), large = ShapeIndex(WithPrincipals(1e30f, 2e30f));
  EXPECT_FLOAT_EQ(small, large);
  EXPECT_FLOAT_EQ(small, static_cast<float>(2.0 / std::acos(-1.0) * std::atan(3.0)));
}

TEST(DerivedQuantitiesTest, APlaneHasNoShapeAndNoCurvedness) {
  EXPECT_TRUE(std::isnan(ShapeIndex(WithPrincipals(0.0f, 0.0f))));
  EXPECT_TRUE(std::isnan(ShapeIndex(WithPrincipals(-0.0f, 0.0f))));
  EXPECT_EQ(Curvedness(WithPrincipals(0.0f, 0.0f)), 0.0f);
}

TEST(DerivedQuantitiesTest, TheCurvednessOfABallIsOneOverItsRadius) {
  EXPECT_FLOAT_EQ(Curvedness(WithPrincipals(0.25f, 0.25f)), 0.25f);
  EXPECT_FLOAT_EQ(Curvedness(WithPrincipals(-3.0f, 4.0f)), std::sqrt(12.5f));
  EXPECT_FLOAT_EQ(Curvedness(WithPrincipals(-3e38f, 3e38f)), 3e38f) << "no overflow";
}

TEST(DerivedQuantitiesTest, PointsWithoutCurvatureHaveNone) {
  const PointCurvature undefined = UndefinedCurvature(PointStatus::kDegenerateArea);
  EXPECT_TRUE(std::isnan(ShapeIndex(undefined)));
  EXPECT_TRUE(std::isnan(Curvedness(undefined)));
}

TEST(DerivedQuantitiesTest, ColumnsGoWhereTheyAreWanted) {
  const std::vector<PointCurvature> points = {WithPrincipals(1.0f, 1.0f), WithPrincipals(0.0f, 1.0f)};
  std::vector<char> bytes(1 + 2 * sizeof(float));
  DeriveColumns(points, {bytes.data() + 1, nullptr});  // not aligned
  float values[2];
  std::memcpy(values, bytes.data() + 1, sizeof(values));
  EXPECT_EQ(values[0], 1.0f);
  EXPECT_EQ(values[1], 0.5f);
}

}  // namespace
}  // namespace curvd::testing
