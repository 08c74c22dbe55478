// Compares an estimate with the double oracle's.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/estimators/curvature_field.h"
#include "tests/core/reference_measures.h"

namespace curvd::testing {

// Curvatures agree to 1e-5 of the larger principal curvature, or where the surface is flat, of a hundredth of the
// neighborhood's own curvature 1 / radius: the rounding of float normals, 6e-8, is 6e-8 / radius in curvature.
inline void ExpectNear(const PointCurvature& point, const ReferenceCurvature& reference) {
  const double scale = std::max({std::abs(reference.k1), std::abs(reference.k2), 1e-2 / reference.radius});
  EXPECT_NEAR(point.mean, reference.mean, 1e-5 * scale);
  // Gaussian curvature has a measure of its own, so k1 and k2 may be small where it is not.
  const double square =
      std::max({scale * scale, reference.gaussian_magnitude, 1e-2 / (reference.radius * reference.radius)});
  EXPECT_NEAR(point.gaussian, reference.gaussian, 1e-5 * square);
  EXPECT_NEAR(point.k1, reference.k1, 1e-5 * scale);
  EXPECT_NEAR(point.k2, reference.k2, 1e-5 * scale);
}

}  // namespace curvd::testing
