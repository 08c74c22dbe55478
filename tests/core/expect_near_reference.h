// Compares the estimates of a cloud with the double oracle's.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>

#include "tests/core/expect_curvature.h"
#include "tests/core/reference_estimator.h"
#include "tests/core/sanitized.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

// Looks at every `step`-th point, or at fewer where a sanitizer looks on, but for those whose neighbors or sectors
// rounding may decide either way.
inline void ExpectNearReference(const TestPoints& points, const EstimatorOptions& options, size_t step) {
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  size_t compared = 0;
  step *= kSparser;
  for (size_t i = 0; i < points.size(); i += step) {
    const PointCurvature& point = result.field.points[i];
    const ReferenceCurvature reference = ReferenceEstimate(points, i, options);
    if (point.status != PointStatus::kOk || !reference.estimated || reference.margin < 1e-5) continue;
    SCOPED_TRACE(i);
    ExpectNear(point, reference);
    ++compared;
  }
  EXPECT_GT(compared, points.size() / step / 2);
}

}  // namespace curvd::testing
