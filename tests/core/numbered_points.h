// Results whose numbers tell where they belong.
#pragma once

#include <cstddef>

#include "core/estimators/curvature_field.h"

namespace curvd {

// Result i: 100 i + 1, 100 i + 2, ... in the order of the members. The statuses take turns, from kOk on.
inline PointCurvature NumberedPoint(size_t i) {
  const float base = 100.0f * static_cast<float>(i);
  PointCurvature point{};
  point.mean = base + 1;
  point.gaussian = base + 2;
  point.k1 = base + 3;
  point.k2 = base + 4;
  point.d1 = {base + 5, base + 6, base + 7};
  point.d2 = {base + 8, base + 9, base + 10};
  point.radius = base + 11;
  point.status = static_cast<PointStatus>(1 + i % (kPointStatusEnd - 1));
  return point;
}

}  // namespace curvd
