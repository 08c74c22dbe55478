#include "core/estimators/fits/least_axis.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/estimators/triangles/random_stream.h"

namespace curvd {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d LeastAxisOf(const Matrix3d& m) {
  const double covariance[6] = {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
  Vector3d axis;
  LeastAxis(covariance, axis.data());
  return axis;
}

Matrix3d RandomRotation(uint64_t seed) {
  RandomStream random(seed, 0);
  const auto draw = [&] { return static_cast<double>(random.Next() >> 11) * 0x1p-53 - 0.5; };
  return Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized().toRotationMatrix();
}

// Spreads along the axes, ascending.
Matrix3d Turned(const Vector3d& spreads, uint64_t seed) {
  const Matrix3d rotation = RandomRotation(seed);
  return rotation * spreads.asDiagonal() * rotation.transpose();
}

TEST(LeastAxisTest, IsTheEigenvectorOfTheSmallestEigenvalue) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    for (const Vector3d& spreads : {Vector3d(0, 1, 1), Vector3d(1e-9, 0.3, 1), Vector3d(0.1, 0.2, 3),
                                    Vector3d(1e-30, 2e-28, 3e-28), Vector3d(1e20, 2e20, 2e20)}) {
      const Vector3d axis = LeastAxisOf(Turned(spreads, seed));
      const Vector3d expected = RandomRotation(seed).col(0);
      ASSERT_NEAR(axis.norm(), 1.0, 1e-14);
      // The matrix's own rounding, over the gap to the next eigenvalue.
      ASSERT_LT(axis.cross(expected).norm(), 1e-14 * spreads[2] / (spreads[1] - spreads[0])) << spreads.transpose();
    }
  }
}

TEST(LeastAxisTest, IsUnitWhereItIsNotUnique) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    for (const Vector3d& spreads : {Vector3d(0, 0, 0), Vector3d(1, 1, 1), Vector3d(0, 0, 1), Vector3d(2, 2, 3)}) {
      const Vector3d axis = LeastAxisOf(Turned(spreads, seed));
      ASSERT_NEAR(axis.norm(), 1.0, 1e-14) << spreads.transpose();
    }
  }
  EXPECT_NEAR(LeastAxisOf(Matrix3d::Identity()).norm(), 1.0, 1e-14);
}

}  // namespace
}  // namespace curvd
