#include "core/estimators/normal_curvature.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace curvd {
namespace {

double Dot(const std::array<float, 3>& a, const Direction& b) {
  return double{a[0]} * b[0] + double{a[1]} * b[1] + double{a[2]} * b[2];
}

}  // namespace

Direction DirectionOf(const std::array<double, 3>& vector) {
  const auto is_finite = [](double component) { return std::isfinite(component); };
  if (!std::all_of(vector.begin(), vector.end(), is_finite)) return {};
  const double most = std::max({std::abs(vector[0]), std::abs(vector[1]), std::abs(vector[2])});
  if (most == 0.0) return {};
  // Squares of very long or short vectors are no doubles.
  const double x = vector[0] / most, y = vector[1] / most, z = vector[2] / most;
  const double length = std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

float NormalCurvature(const PointCurvature& point, const Direction& direction) {
  constexpr double kLeastProjection = 1e-6;
  const double along1 = Dot(point.d1, direction), along2 = Dot(point.d2, direction);
  const double first = along1 * along1, second = along2 * along2;
  if (!(first + second > kLeastProjection * kLeastProjection)) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>((point.k1 * first + point.k2 * second) / (first + second));
}

void WriteNormalCurvatures(std::span<const PointCurvature> points, std::span<const Direction> directions, char* out) {
  const bool is_one = directions.size() == 1;
  for (size_t i = 0; i < points.size(); ++i) {
    const float value = NormalCurvature(points[i], directions[is_one ? 0 : i]);
    std::memcpy(out + i * sizeof(value), &value, sizeof(value));
  }
}

}  // namespace curvd
