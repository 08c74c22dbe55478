#include "core/estimators/lines/line_test.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/estimators/lines/offset_sums.h"

namespace curvd {
namespace {

// Neighbors lie along a line if their standard deviation across it is at most so much of that along it, and at most so
// much of that along the normal: noise could be all of their width. Or if it is next to nothing, whatever the noise is.
constexpr double kLineWidth = 0.1, kLineWidthPerThickness = 2.0, kHairWidth = 0.01;

// Fewer neighbors are compared with their mean: a parabola would take away too much of their spread.
constexpr size_t kLeastForParabola = 16;

using Vector = std::array<double, 3>;

double Dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The offsets in units of the radius, with their weights.
class WeightedOffsets {
 public:
  WeightedOffsets(const NeighborOffsets& neighbors, float radius, bool fades)
      : neighbors_(neighbors), unit_(1.0 / double{radius}), fades_(fades) {}

  template <typename Visit>
  void ForEach(Visit visit) const {
    for (size_t j = 0; j < neighbors_.count; ++j) {
      const Vector q = {neighbors_.x[j] * unit_, neighbors_.y[j] * unit_, neighbors_.z[j] * unit_};
      const double inner = fades_ ? std::max(1.0 - Dot(q, q), 0.0) : 1.0;
      visit(q, inner * inner);
    }
  }

 private:
  const NeighborOffsets& neighbors_;
  const double unit_;
  const bool fades_;
};

// The direction in the plane normal to n in which the offsets spread most.
Vector WidestDirection(const WeightedOffsets& offsets, const Vector& n) {
  OffsetSums<10> sums;  // of weights, offsets and their products
  offsets.ForEach([&](const Vector& q, double w) {
    sums.Add(0, w);
    for (size_t a = 0, entry = 4; a < 3; ++a) {
      sums.Add(1 + a, w * q[a]);
      for (size_t b = a; b < 3; ++b, ++entry) sums.Add(entry, w * q[a] * q[b]);
    }
  });
  // Any two axes of the plane (Duff et al., "Building an orthonormal basis, revisited", 2017).
  const double sign = std::copysign(1.0, n[2]), a = -1.0 / (sign + n[2]), b = n[0] * n[1] * a;
  const Vector u = {1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, v = {b, sign + n[1] * n[1] * a, -n[1]};
  const Vector mean = {sums[1] / sums[0], sums[2] / sums[0], sums[3] / sums[0]};
  const auto covariance = [&](const Vector& x, const Vector& y) {
    double sum = 0.0;
    for (size_t i = 0, entry = 4; i < 3; ++i) {
      for (size_t j = i; j < 3; ++j, ++entry) {
        sum += sums[entry] / sums[0] * (i == j ? x[i] * y[i] : x[i] * y[j] + x[j] * y[i]);
      }
    }
    return sum - Dot(mean, x) * Dot(mean, y);
  };
  const double angle = 0.5 * std::atan2(2.0 * covariance(u, v), covariance(u, u) - covariance(v, v));
  const double cosine = std::cos(angle), sine = std::sin(angle);
  return {cosine * u[0] + sine * v[0], cosine * u[1] + sine * v[1], cosine * u[2] + sine * v[2]};
}

}  // namespace

bool LineSpread::IsLine() const {
  return across <= kHairWidth * along || (across <= kLineWidth * along && across <= kLineWidthPerThickness * thickness);
}

LineSpread MeasureLine(const NeighborOffsets& neighbors, const float* normal, float radius, bool fades) {
  const WeightedOffsets offsets(neighbors, radius, fades);
  const Vector n = {normal[0], normal[1], normal[2]}, along = WidestDirection(offsets, n), across = Cross(n, along);
  // Sums of powers of x, and of y and z times them; y and z are squared last.
  OffsetSums<13> sums;
  offsets.ForEach([&](const Vector& q, double w) {
    const double x = Dot(q, along), y = Dot(q, across), z = Dot(q, n);
    double power = w;
    for (size_t p = 0; p < 5; ++p, power *= x) sums.Add(p, power);
    power = w;
    for (size_t p = 0; p < 3; ++p, power *= x) {
      sums.Add(5 + p, y * power);
      sums.Add(9 + p, z * power);
    }
    sums.Add(8, w * y * y);
    sums.Add(12, w * z * z);
  });
  const auto mean = [&](size_t sum) { return sums[sum] / sums[0]; };
  const double m1 = mean(1), variance = mean(2) - m1 * m1;
  // What x^2 adds to 1 and x.
  const double slope = variance > 0.0 ? (mean(3) - m1 * mean(2)) / variance : 0.0;
  const double square = mean(4) - mean(2) * mean(2) - slope * slope * variance;
  const auto rest = [&](size_t first) {
    const double linear = mean(first + 1) - mean(first) * m1;
    double left = mean(first + 3) - mean(first) * mean(first);
    if (neighbors.count < kLeastForParabola) return std::sqrt(std::max(left, 0.0));
    if (variance > 0.0) left -= linear * linear / variance;
    const double bend = mean(first + 2) - mean(first) * mean(2) - slope * linear;
    if (square > 1e-9) left -= bend * bend / square;
    return std::sqrt(std::max(left, 0.0));
  };
  return {std::sqrt(std::max(variance, 0.0)), rest(5), rest(9)};
}

}  // namespace curvd
