#include "core/estimators/derived_quantities.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

namespace curvd {

float ShapeIndex(const PointCurvature& point) {
  const double k1 = point.k1, k2 = point.k2;
  if (k1 == 0.0 && k2 == 0.0) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(std::numbers::inv_pi * 2.0 * std::atan2(k1 + k2, k2 - k1));
}

float Curvedness(const PointCurvature& point) {
  return static_cast<float>(std::hypot(double{point.k1}, double{point.k2}) / std::numbers::sqrt2);
}

void DeriveColumns(std::span<const PointCurvature> points, const DerivedPlaces& places) {
  for (size_t column = 0; column < places.size(); ++column) {
    char* out = places[column];
    if (out == nullptr) continue;
    for (const PointCurvature& point : points) {
      const float value = kDerivedColumns[column].value(point);
      std::memcpy(out, &value, sizeof(value));
      out += sizeof(value);
    }
  }
}

}  // namespace curvd
