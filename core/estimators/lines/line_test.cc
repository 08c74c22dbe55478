#include "core/estimators/lines/line_test.h"

#include <algorithm>
#include <array>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/lines/line_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/lines/offset_sums-inl.h"
#include "hwy/highway.h"

#ifndef CURVD_CORE_ESTIMATORS_LINES_LINE_TEST_CC_
#define CURVD_CORE_ESTIMATORS_LINES_LINE_TEST_CC_
namespace curvd {

// The sums over offsets q with weights w.
using SpreadSums = std::array<double, 10>;  // of w, w q and w q q
// In the axes x along the line, y across it and z along the normal: of w x^p for p < 5; of w y x^p for p < 3 and
// w y^2; of the same with z.
using LineSums = std::array<double, 13>;

struct LineAxes {
  std::array<double, 3> along, across, normal;
};

}  // namespace curvd
#endif  // CURVD_CORE_ESTIMATORS_LINES_LINE_TEST_CC_

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Calls visit(q, w) for vectors of offsets in units of the radius, and their weights. Behind the last one, both are 0.
template <typename Visit>
HWY_INLINE void ForEachWeighted(const NeighborOffsets& neighbors, float radius, bool fades, Visit visit) {
  const DoubleTag d;
  const DoubleVec unit = hn::Set(d, 1.0 / double{radius}), one = hn::Set(d, 1.0);
  for (size_t j = 0; j < neighbors.count; j += hn::Lanes(d)) {
    const DoubleMask used = hn::FirstN(d, neighbors.count - j);
    const auto load = [&](const ScratchArray<float>& axis)
                          HWY_ATTR { return hn::IfThenElseZero(used, hn::Mul(Widen(axis.data() + j), unit)); };
    const DoubleTriple q{load(neighbors.x), load(neighbors.y), load(neighbors.z)};
    DoubleVec inner = one;
    if (fades) inner = hn::Max(hn::Sub(one, RoundedDot(q, q)), hn::Zero(d));
    visit(q, hn::IfThenElseZero(used, hn::Mul(inner, inner)));
  }
}

SpreadSums SumSpread(const NeighborOffsets& neighbors, float radius, bool fades) {
  VectorOffsetSums<10> sums;
  ForEachWeighted(neighbors, radius, fades, [&](const DoubleTriple& q, DoubleVec w) HWY_ATTR {
    const DoubleVec x = hn::Mul(w, q.x), y = hn::Mul(w, q.y), z = hn::Mul(w, q.z);
    sums.Add({w, x, y, z, hn::Mul(x, q.x), hn::Mul(x, q.y), hn::Mul(x, q.z), hn::Mul(y, q.y), hn::Mul(y, q.z),
              hn::Mul(z, q.z)});
  });
  return sums.Total();
}

LineSums SumLine(const NeighborOffsets& neighbors, const LineAxes& axes, float radius, bool fades) {
  const DoubleTag d;
  const auto axis = [d](const std::array<double, 3>& a) HWY_ATTR {
    return DoubleTriple{hn::Set(d, a[0]), hn::Set(d, a[1]), hn::Set(d, a[2])};
  };
  const DoubleTriple along = axis(axes.along), across = axis(axes.across), normal = axis(axes.normal);
  VectorOffsetSums<13> sums;
  ForEachWeighted(neighbors, radius, fades, [&](const DoubleTriple& q, DoubleVec w) HWY_ATTR {
    const DoubleVec x = RoundedDot(q, along), y = RoundedDot(q, across), z = RoundedDot(q, normal);
    const DoubleVec wx = hn::Mul(w, x), wxx = hn::Mul(wx, x), wxxx = hn::Mul(wxx, x);
    sums.Add({w, wx, wxx, wxxx, hn::Mul(wxxx, x), hn::Mul(y, w), hn::Mul(y, wx), hn::Mul(y, wxx),
              hn::Mul(hn::Mul(w, y), y), hn::Mul(z, w), hn::Mul(z, wx), hn::Mul(z, wxx), hn::Mul(hn::Mul(w, z), z)});
  });
  return sums.Total();
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(SumSpread);
HWY_EXPORT(SumLine);

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

// The direction in the plane normal to n in which the offsets spread most.
Vector WidestDirection(const SpreadSums& sums, const Vector& n) {
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
  const Vector n = {normal[0], normal[1], normal[2]};
  const Vector along = WidestDirection(HWY_DYNAMIC_DISPATCH(SumSpread)(neighbors, radius, fades), n);
  const LineSums sums = HWY_DYNAMIC_DISPATCH(SumLine)(neighbors, {along, Cross(n, along), n}, radius, fades);
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

#endif  // HWY_ONCE
