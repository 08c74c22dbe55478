#include "core/scale/principal_directions.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace curvd {
namespace {

using Eigen::Vector3d;

const Vector3d kU = Vector3d(1.0, 2.0, 2.0) / 3.0, kV = Vector3d(2.0, 1.0, -2.0) / 3.0;

void ExpectNear(const std::array<float, 3>& found, const Vector3d& expected) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[static_cast<size_t>(i)], expected[i], 1e-7) << i;  // a float's rounding
}

TEST(PrincipalDirectionsTest, LiesAlongTheAxisOfTheLargerEntry) {
  const Vector3d normal = kU.cross(kV);
  const auto along_u = DirectionsOf(2.0, 0.0, kU, kV, normal), along_v = DirectionsOf(-2.0, 0.0, kU, kV, normal);
  ExpectNear(along_u.d2, kU);
  ExpectNear(along_u.d1, -kV);
  ExpectNear(along_v.d2, kV);
  ExpectNear(along_v.d1, kU);
}

TEST(PrincipalDirectionsTest, LiesBetweenTheAxesWhereTheirEntriesAreEqual) {
  const Vector3d normal = kU.cross(kV);
  const auto found = DirectionsOf(0.0, 0.5, kU, kV, normal);
  ExpectNear(found.d2, (kU + kV) / std::sqrt(2.0));
  ExpectNear(found.d1, (kU - kV) / std::sqrt(2.0));
}

TEST(PrincipalDirectionsTest, IsTheFirstAxisOfAnUmbilic) {
  ExpectNear(DirectionsOf(0.0, 0.0, kU, kV, kU.cross(kV)).d2, kU);
}

}  // namespace
}  // namespace curvd
