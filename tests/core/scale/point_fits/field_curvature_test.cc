#include "core/scale/point_fits/field_curvature.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace curvd::testing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A few units in the last place of a float.
constexpr double kFloatRounding = 1e-6;

// A field over the plane across z: its value, and its derivatives along x and y, from those of the frame.
Matrix3d FieldInFrame(const NormalFrame& frame, const Vector3d& value, const Vector3d& along_x,
                      const Vector3d& along_y) {
  Matrix3d field;
  field.row(0) = value;
  field.row(1) = frame.u.x() * along_x + frame.u.y() * along_y;
  field.row(2) = frame.v.x() * along_x + frame.v.y() * along_y;
  return field;
}

Vector3d VectorOf(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

// The normals of a sphere of radius 1 around the origin over the place (x, y), from a plane across z.
Matrix3d FieldOfSphere(const NormalFrame& frame, double x, double y) {
  const double z = std::sqrt(1.0 - x * x - y * y);
  return FieldInFrame(frame, {x, y, z}, {1.0, 0.0, -x / z}, {0.0, 1.0, -y / z});
}

TEST(FieldCurvatureTest, SpheresHaveTheInverseOfTheirRadius) {
  const NormalFrame frame(Vector3d::UnitZ());
  for (const double x : {0.0, 0.3, 0.7}) {
    const auto point = CurvatureOfField(frame, FieldOfSphere(frame, x, -0.2), 1.0, 0.25);
    ASSERT_TRUE(point.has_value()) << x;
    EXPECT_NEAR(point->mean, 1.0, kFloatRounding);
    EXPECT_NEAR(point->gaussian, 1.0, kFloatRounding);
    EXPECT_NEAR(point->k1, 1.0, kFloatRounding);
    EXPECT_NEAR(point->k2, 1.0, kFloatRounding);
    EXPECT_EQ(point->radius, 0.25f);
    EXPECT_EQ(point->status, PointStatus::kOk);
    const Vector3d normal(x, -0.2, std::sqrt(1.0 - x * x - 0.04)), d1 = VectorOf(point->d1), d2 = VectorOf(point->d2);
    EXPECT_LT((d1.cross(d2) - normal).norm() * (d1.cross(d2) + normal).norm(), kFloatRounding);
  }
}

TEST(FieldCurvatureTest, SaddlesHaveCurvaturesOfBothSigns) {
  // z = (x^2 - y^2) / 2, turned by an angle: k1 is where it bends up, since normals point up.
  for (const double angle : {0.0, 0.5, 2.0}) {
    const NormalFrame frame(Vector3d::UnitZ());
    const Vector3d up(std::cos(angle), std::sin(angle), 0.0), down(-up.y(), up.x(), 0.0);
    const auto along = [&](double x, double y) -> Vector3d {
      const Vector3d tangent(x, y, 0.0);
      return -tangent.dot(up) * up + tangent.dot(down) * down;
    };
    const Matrix3d field = FieldInFrame(frame, Vector3d::UnitZ(), along(1.0, 0.0), along(0.0, 1.0));
    const auto point = CurvatureOfField(frame, field, 1.0, 1.0);
    ASSERT_TRUE(point.has_value()) << angle;
    EXPECT_NEAR(point->mean, 0.0, kFloatRounding);
    EXPECT_NEAR(point->gaussian, -1.0, kFloatRounding);
    EXPECT_NEAR(point->k1, -1.0, kFloatRounding);
    EXPECT_NEAR(point->k2, 1.0, kFloatRounding);
    EXPECT_NEAR(std::abs(VectorOf(point->d1).dot(up)), 1.0, kFloatRounding);
    EXPECT_NEAR(std::abs(VectorOf(point->d2).dot(down)), 1.0, kFloatRounding);
  }
}

TEST(FieldCurvatureTest, NeitherTheUnitNorTheLengthOfNormalsMatters) {
  const NormalFrame frame(Vector3d::UnitZ());
  // In tenths, changes are a tenth; what fits have averaged is shorter than 1, with all that it changes by.
  Matrix3d field = 0.6 * FieldOfSphere(frame, 0.3, 0.1);
  field.bottomRows<2>() *= 0.1;
  const auto point = CurvatureOfField(frame, field, 0.1, 0.1);
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->k1, 1.0, kFloatRounding);
  EXPECT_NEAR(point->k2, 1.0, kFloatRounding);
}

TEST(FieldCurvatureTest, FieldsThatDetermineNothingTellNothing) {
  const NormalFrame frame(Vector3d::UnitZ());
  const Matrix3d field = FieldOfSphere(frame, 0.0, 0.0);
  const auto has_curvature = [&](const Vector3d& value, double times) {
    Matrix3d changed = times * field;
    changed.row(0) = value;
    return CurvatureOfField(frame, changed, 1.0, 1.0).has_value();
  };
  EXPECT_TRUE(has_curvature(Vector3d::UnitZ(), 1.0));
  EXPECT_FALSE(has_curvature(Vector3d::Zero(), 1.0));
  EXPECT_FALSE(has_curvature(-Vector3d::UnitZ(), 1.0));
  EXPECT_FALSE(has_curvature({1.0, 0.0, 0.05}, 1.0)) << "in the plane, nearly";
  EXPECT_FALSE(has_curvature({std::nan(""), 0.0, 1.0}, 1.0));
  EXPECT_FALSE(has_curvature(Vector3d::UnitZ(), std::nan("")));
  EXPECT_TRUE(has_curvature(Vector3d::UnitZ(), 1e18));
  EXPECT_FALSE(has_curvature(Vector3d::UnitZ(), 1e20)) << "the Gaussian curvature is beyond floats";
  EXPECT_FALSE(has_curvature(Vector3d::UnitZ(), 1e200));
}

PointFit FitToScale() {
  const PointCurvature point = {
      1.5f, 2.0f, 1.0f, 2.0f, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, 0.25f, PointStatus::kOk};
  return {point, 64, 0.1, 0.2, 0.3, true};
}

TEST(FieldCurvatureTest, ScalingChangesTheUnit) {
  const auto fit = Scaled(FitToScale(), 4.0);
  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->point.mean, 6.0f);
  EXPECT_EQ(fit->point.gaussian, 32.0f);
  EXPECT_EQ(fit->point.k1, 4.0f);
  EXPECT_EQ(fit->point.k2, 8.0f);
  EXPECT_EQ(fit->point.radius, 0.0625f);
  EXPECT_EQ(fit->point.d1, FitToScale().point.d1);
  EXPECT_EQ(fit->point.d2, FitToScale().point.d2);
  EXPECT_EQ(fit->point.status, PointStatus::kOk);
  EXPECT_EQ(fit->neighbor_count, 64u);
  EXPECT_EQ(fit->mean_error, 0.4);
  EXPECT_EQ(fit->k1_error, 0.8);
  EXPECT_EQ(fit->k2_error, 1.2);
  EXPECT_TRUE(fit->is_by_heights);
}

TEST(FieldCurvatureTest, ValuesBeyondFloatsAreNone) {
  // The Gaussian curvature grows with the square of the factor.
  EXPECT_TRUE(Scaled(FitToScale(), 0x1p63).has_value());
  EXPECT_FALSE(Scaled(FitToScale(), 0x1p64).has_value());
  EXPECT_FALSE(Scaled(FitToScale().point, 0x1p64).has_value());
  PointCurvature flat = FitToScale().point;
  flat.gaussian = flat.k1 = 0.0f;
  EXPECT_TRUE(Scaled(flat, 0x1p126).has_value());
  EXPECT_FALSE(Scaled(flat, 0x1p127).has_value());
  flat.k2 = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(Scaled(flat, 1.0).has_value());
}

}  // namespace
}  // namespace curvd::testing
