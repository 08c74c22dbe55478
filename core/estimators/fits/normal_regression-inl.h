// Local polynomial regression of the normals (docs/numerics.md): each component of the neighbors' normals is fitted by
// a polynomial of degree 2 or 3 over the tangent plane (x, y), by least squares with weights w = 1 - (x^2 + y^2) /
// rho^2. The derivative of the fitted field over the surface's tangent plane at the point is its shape operator.

#if defined(CURVD_CORE_ESTIMATORS_FITS_NORMAL_REGRESSION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_NORMAL_REGRESSION_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_NORMAL_REGRESSION_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_NORMAL_REGRESSION_INL_H_
#endif

#include <algorithm>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/fits/regression_systems.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/frames-inl.h"
#include "core/estimators/lines/curve_distance.h"
#include "core/estimators/lines/offset_sums.h"
#include "core/estimators/lines/refuse_lines-inl.h"
#include "core/estimators/neighbors/neighbors.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Has the compiler unroll a loop of `n` rounds, so that what it indexes stays in registers.
#ifndef CURVD_UNROLL
#define CURVD_UNROLL_PRAGMA(text) _Pragma(#text)
#define CURVD_UNROLL(n) CURVD_UNROLL_PRAGMA(GCC unroll n)
#endif

// What a monomial adds to those before it, in square mean, is at least this fraction of its own square mean where the
// neighbors determine its coefficient.
inline constexpr double kMinRegressionPivot = 1e-6;
// Where what a monomial adds has a lower mean square than this, by its degree, the neighbors may lie near a curve.
// Those of an even disc are 16 times as large.
inline constexpr double kDoubtfulRegressionPivot[kRegressionDegree + 1] = {0.0, 0.01, 2e-3, 4.5e-4};
// Neighbors that spread less than the root of this in one tangent direction, compared with the other, lie on a line.
inline constexpr double kMinRegressionSpread = 1e-6;

// Some neighbors of a point over its tangent plane, x and y in units of rho.
struct PlaneBlock {
  static constexpr size_t kSize = 256;
  alignas(64) double x[kSize];
  alignas(64) double y[kSize];
  alignas(64) double w[kSize];  // weights, Odd; nothing for what pads the last vector
};

// The axes of the tangent plane, divided by rho.
struct PlaneAxes {
  double u[3], v[3];

  PlaneAxes(const GroupFrames& frames, size_t i) {
    const double unit = 1.0 / frames.rho[i];
    const GroupScalars* from[2][3] = {{&frames.u.x, &frames.u.y, &frames.u.z}, {&frames.v.x, &frames.v.y, &frames.v.z}};
    for (int axis = 0; axis < 3; ++axis) {
      u[axis] = (*from[0][axis])[i] * unit;
      v[axis] = (*from[1][axis])[i] * unit;
    }
  }
};

// Fills the block with `size` neighbors from `first` on.
HWY_INLINE void FillBlock(const NeighborArrays& n, size_t first, size_t size, const PlaneAxes& axes,
                          PlaneBlock& block) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), zero = hn::Zero(d);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const size_t k = first + j;
    const DoubleVec dx = Widen(n.dx.data() + k), dy = Widen(n.dy.data() + k), dz = Widen(n.dz.data() + k);
    const auto along = [&](const double* axis) HWY_ATTR {
      return hn::MulAdd(dz, hn::Set(d, axis[2]), hn::MulAdd(dy, hn::Set(d, axis[1]), hn::Mul(dx, hn::Set(d, axis[0]))));
    };
    const DoubleVec x = along(axes.u), y = along(axes.v);
    const DoubleVec w = hn::Max(hn::NegMulAdd(y, y, hn::NegMulAdd(x, x, one)), zero);
    hn::Store(x, d, block.x + j);
    hn::Store(y, d, block.y + j);
    hn::Store(Odd(w), d, block.w + j);
  }
  for (size_t j = size; j % hn::Lanes(d) != 0; ++j) block.w[j] = hn::GetLane(Odd(zero));
}

// Where the monomials that the normals are multiplied by are among all, by JetIndex, in the order of their sums.
inline constexpr int kMonomialPlaces[kRegressionSize] = {JetIndex(0, 0), JetIndex(1, 0), JetIndex(2, 0), JetIndex(3, 0),
                                                         JetIndex(2, 1), JetIndex(0, 1), JetIndex(1, 1), JetIndex(0, 2),
                                                         JetIndex(1, 2), JetIndex(0, 3)};

// The sums of one point, a vector of them each, whose lanes are added up when all neighbors are in them. They begin at
// an anchor.
struct RegressionSums {
  static constexpr size_t kLanes = hn::MaxLanes(DoubleTag());
  static constexpr int kLow = 16, kHigh = 12, kNormals = 3 * kRegressionSize, kAll = kLow + kHigh + kNormals;
  alignas(64) double lanes[kAll * kLanes];

  explicit RegressionSums(DoubleVec anchor) {
    for (int k = 0; k < kAll; ++k) hn::Store(anchor, DoubleTag(), lanes + static_cast<size_t>(k) * kLanes);
  }
  double* low(int power_of_y) { return lanes + static_cast<size_t>(4 * power_of_y) * kLanes; }
  double* high(int half) { return lanes + static_cast<size_t>(kLow + half * kHigh / 2) * kLanes; }
  double* normals(int monomial) { return lanes + static_cast<size_t>(kLow + kHigh + 3 * monomial) * kLanes; }

  // Adds up all lanes, and copies the sums to point i.
  void Store(DoubleVec anchor, size_t i, RegressionSystems& out) const {
    double sums[kAll + 3];
    for (int k = 0; k < kAll; k += 4) {
      const auto at = [&](int m) HWY_ATTR {
        return hn::Load(DoubleTag(), lanes + static_cast<size_t>(std::min(k + m, kAll - 1)) * kLanes);
      };
      StoreAnchoredSums(at(0), at(1), at(2), at(3), anchor, sums + k);
    }
    const double* next = sums;
    for (int b = 0; b < 4; ++b) {
      for (int a = 0; a < 4; ++a) out.moments[JetIndex(a, b)][i] = *next++;
    }
    constexpr int kPowers[6][2] = {{4, 0}, {5, 0}, {6, 0}, {4, 1}, {5, 1}, {4, 2}};
    for (const auto& powers : kPowers) out.moments[JetIndex(powers[0], powers[1])][i] = *next++;
    for (const auto& powers : kPowers) out.moments[JetIndex(powers[1], powers[0])][i] = *next++;
    for (const int m : kMonomialPlaces) {
      for (int c = 0; c < 3; ++c) out.normals[c][m][i] = *next++;
    }
  }
};

// Whether there are 32 vector registers, or 16. A sum that waits in memory is late to be loaded: each pass over a block
// has as many as leave some registers to what it multiplies.
#if (HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86) || HWY_ARCH_ARM_A64
inline constexpr bool kManyRegisters = true;
#else
inline constexpr bool kManyRegisters = false;
#endif

// As many sums as registers hold: loops over them are unrolled. Loaded from and stored to a part of RegressionSums.
template <int kCount>
struct SumsInRegisters {
  HWY_INLINE explicit SumsInRegisters(const double* from) {
    CURVD_UNROLL(16)
    for (int k = 0; k < kCount; ++k)
      sum[k] = hn::Load(DoubleTag(), from + static_cast<size_t>(k) * RegressionSums::kLanes);
  }
  HWY_INLINE void Store(double* to) const {
    CURVD_UNROLL(16)
    for (int k = 0; k < kCount; ++k)
      hn::Store(sum[k], DoubleTag(), to + static_cast<size_t>(k) * RegressionSums::kLanes);
  }
  DoubleVec sum[kCount];
};

// What a block adds to the sums of a point.

// Adds w x^a y^b for a <= 3 and b from kFirst up to kEnd - 1 to sums[4 (b - kFirst) + a].
template <int kFirst, int kEnd>
HWY_NOINLINE inline void SumLowMoments(const PlaneBlock& block, size_t size, DoubleVec anchor, double* sums) {
  const DoubleTag d;
  SumsInRegisters<4 * (kEnd - kFirst)> s(sums);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const DoubleVec x = hn::Load(d, block.x + j), x2 = hn::Mul(x, x), x3 = hn::Mul(x2, x);
    const DoubleVec y = hn::Load(d, block.y + j);
    DoubleVec wy = hn::Load(d, block.w + j);
    CURVD_UNROLL(4)
    for (int b = 0; b < kEnd; ++b) {
      if (b > 0) wy = OddProduct(wy, y);
      if (b < kFirst) continue;
      DoubleVec* const of_b = &s.sum[4 * static_cast<size_t>(b - kFirst)];
      of_b[0] = hn::Add(of_b[0], wy);
      of_b[1] = AddProduct(wy, x, of_b[1], anchor);
      of_b[2] = AddProduct(wy, x2, of_b[2], anchor);
      of_b[3] = AddProduct(wy, x3, of_b[3], anchor);
    }
  }
  s.Store(sums);
}

// Adds w times x^4, x^5, x^6, x^4 y, x^5 y, x^4 y^2 to sums[0..5]; with two halves, the same with x and y in each
// other's place to sums[6..11].
template <int kHalves>
HWY_NOINLINE inline void SumHighMoments(const double* xs, const double* ys, const double* weights, size_t size,
                                        DoubleVec anchor, double* sums) {
  const DoubleTag d;
  SumsInRegisters<6 * kHalves> s(sums);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const DoubleVec x = hn::Load(d, xs + j), y = hn::Load(d, ys + j), w = hn::Load(d, weights + j);
    const DoubleVec x2 = hn::Mul(x, x), xy = hn::Mul(x, y), y2 = hn::Mul(y, y);
    const auto add_half = [&](DoubleVec* half, DoubleVec a, DoubleVec a2, DoubleVec b, DoubleVec b2) HWY_ATTR {
      const DoubleVec wa4 = OddProduct(hn::Mul(w, a2), a2);
      half[0] = hn::Add(half[0], wa4);
      half[1] = AddProduct(wa4, a, half[1], anchor);
      half[2] = AddProduct(wa4, a2, half[2], anchor);
      half[3] = AddProduct(wa4, b, half[3], anchor);
      half[4] = AddProduct(wa4, xy, half[4], anchor);
      half[5] = AddProduct(wa4, b2, half[5], anchor);
    };
    add_half(s.sum, x, x2, y, y2);
    if constexpr (kHalves == 2) add_half(s.sum + 6, y, y2, x, x2);
  }
  s.Store(sums);
}

// The weighted monomials, Odd, in the order of kMonomialPlaces.
HWY_INLINE void WeightedMonomials(DoubleVec x, DoubleVec y, DoubleVec w, DoubleVec* out) {
  out[0] = w, out[1] = OddProduct(w, x), out[2] = OddProduct(out[1], x), out[3] = OddProduct(out[2], x);
  out[4] = OddProduct(out[2], y);
  out[5] = OddProduct(w, y), out[6] = OddProduct(out[5], x), out[7] = OddProduct(out[5], y);
  out[8] = OddProduct(out[7], x), out[9] = OddProduct(out[7], y);
}

// Adds the normals' components times weighted monomials kFirst up to kEnd - 1 to sums[3 (m - kFirst) + component].
template <int kFirst, int kEnd>
HWY_NOINLINE inline void SumNormalProducts(const PlaneBlock& block, const NeighborArrays& n, size_t first, size_t size,
                                           DoubleVec anchor, double* sums) {
  const DoubleTag d;
  SumsInRegisters<3 * (kEnd - kFirst)> s(sums);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const size_t k = first + j;
    const DoubleVec nx = Widen(n.nx.data() + k), ny = Widen(n.ny.data() + k), nz = Widen(n.nz.data() + k);
    DoubleVec monomials[kRegressionSize];
    WeightedMonomials(hn::Load(d, block.x + j), hn::Load(d, block.y + j), hn::Load(d, block.w + j), monomials);
    CURVD_UNROLL(5)
    for (int m = kFirst; m < kEnd; ++m) {
      DoubleVec* const of_m = &s.sum[3 * static_cast<size_t>(m - kFirst)];
      of_m[0] = AddProduct(monomials[m], nx, of_m[0], anchor);
      of_m[1] = AddProduct(monomials[m], ny, of_m[1], anchor);
      of_m[2] = AddProduct(monomials[m], nz, of_m[2], anchor);
    }
  }
  s.Store(sums);
}

// Adds neighbors from `first` on, which are in the block, to the sums of a point. Those of normals that only a higher
// degree needs are left out; moments are not, since pivots are made of all of them.
HWY_INLINE void AddBlock(const PlaneBlock& block, const NeighborArrays& n, size_t first, size_t size, int degree,
                         DoubleVec anchor, RegressionSums& sums) {
  if constexpr (kManyRegisters) {
    SumLowMoments<0, 4>(block, size, anchor, sums.low(0));
    SumHighMoments<2>(block.x, block.y, block.w, size, anchor, sums.high(0));
  } else {
    SumLowMoments<0, 2>(block, size, anchor, sums.low(0));
    SumLowMoments<2, 4>(block, size, anchor, sums.low(2));
    SumHighMoments<1>(block.x, block.y, block.w, size, anchor, sums.high(0));
    SumHighMoments<1>(block.y, block.x, block.w, size, anchor, sums.high(1));
  }
  if (degree == kRegressionDegree) {
    SumNormalProducts<0, 5>(block, n, first, size, anchor, sums.normals(0));
    SumNormalProducts<5, 10>(block, n, first, size, anchor, sums.normals(5));
  } else {
    SumNormalProducts<0, 3>(block, n, first, size, anchor, sums.normals(0));
    SumNormalProducts<5, 8>(block, n, first, size, anchor, sums.normals(5));
  }
}

// Sets up the problem of point i, whose tangent frame is set, from its neighbors, in polynomials of that degree.
HWY_NOINLINE inline void SumRegression(const NeighborArrays& n, const GroupFrames& frames, size_t i, int degree,
                                       RegressionSystems& systems) {
  const PlaneAxes axes(frames, i);
  const DoubleVec anchor = hn::Set(DoubleTag(), AnchorOf(n.count));
  PlaneBlock block;
  RegressionSums sums(anchor);
  for (size_t first = 0; first < n.count; first += PlaneBlock::kSize) {
    const size_t size = std::min(PlaneBlock::kSize, n.count - first);
    FillBlock(n, first, size, axes, block);
    AddBlock(block, n, first, size, degree, anchor, sums);
  }
  sums.Store(anchor, i, systems);
  systems.most_degree[i] = degree;
}

// Value and derivatives by x and y, at the point, of the polynomials that fit the normals' components.
struct FittedNormals {
  DoubleTriple value, by_x, by_y;
  DoubleVec degree;
  DoubleMask doubtful;
};

// Powers of x and y in the monomials, by JetIndex.
struct MonomialPowers {
  int a[kRegressionSize], b[kRegressionSize];

  constexpr MonomialPowers() : a{}, b{} {
    for (int degree = 0; degree <= kRegressionDegree; ++degree) {
      for (int y = 0; y <= degree; ++y) {
        a[JetIndex(degree - y, y)] = degree - y;
        b[JetIndex(degree - y, y)] = y;
      }
    }
  }
};
inline constexpr MonomialPowers kMonomials;

// The normal equations of points i, i + 1, ... by Cholesky's method: the lower triangle, diagonals inverted, and the
// right sides as three more rows. The factor of a lower degree is a part of that of a higher one.
struct RegressionFactor {
  DoubleVec rows[kRegressionSize + 3][kRegressionSize];
  DoubleMask determined[kRegressionDegree + 1];  // whether the neighbors tell the monomials up to a degree apart
  DoubleMask doubtful;                           // whether they may lie near a curve
};

HWY_INLINE void FactorRegression(const RegressionSystems& systems, size_t i, RegressionFactor& f) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), least = hn::Set(d, kMinRegressionPivot);
  const DoubleVec most_degree = hn::Load(d, systems.most_degree + i);
  const DoubleVec weight = hn::Load(d, systems.moments[0] + i);
  f.doubtful = hn::Lt(one, one);
  DoubleMask determined = hn::Gt(hn::Load(d, systems.moments[0] + i), hn::Zero(d));
  DoubleVec x_spread = hn::Zero(d);
  CURVD_UNROLL(10)
  for (int c = 0; c < kRegressionSize; ++c) {
    const double* squares = systems.moments[JetIndex(2 * kMonomials.a[c], 2 * kMonomials.b[c])] + i;
    const DoubleVec square = hn::Load(d, squares), bound = hn::Mul(least, square);
    DoubleVec pivot = square;
    CURVD_UNROLL(10)
    for (int k = 0; k < c; ++k) pivot = hn::NegMulAdd(f.rows[c][k], f.rows[c][k], pivot);
    determined = hn::And(determined, hn::Gt(pivot, bound));
    const int degree = kMonomials.a[c] + kMonomials.b[c];
    const DoubleMask wanted = hn::Ge(most_degree, hn::Set(d, degree));
    determined = hn::And(determined, wanted);
    const DoubleMask small = hn::Lt(pivot, hn::Mul(hn::Set(d, kDoubtfulRegressionPivot[degree]), weight));
    f.doubtful = hn::Or(f.doubtful, hn::And(wanted, small));
    if (c == JetIndex(1, 0)) x_spread = pivot;
    if (c == JetIndex(0, 1)) {
      // Pivots of x, and of y beside x: their product is the determinant of the covariance.
      const DoubleVec trace = hn::Add(x_spread, hn::MulAdd(f.rows[c][1], f.rows[c][1], pivot));
      const DoubleVec narrow = hn::Mul(hn::Set(d, kMinRegressionSpread), hn::Mul(trace, trace));
      determined = hn::And(determined, hn::Gt(hn::Mul(x_spread, pivot), narrow));
    }
    const DoubleVec inverse = hn::Div(one, hn::Sqrt(hn::Max(pivot, bound)));
    f.rows[c][c] = inverse;
    CURVD_UNROLL(12)
    for (int r = c + 1; r < kRegressionSize + 3; ++r) {
      const double* entry =
          r >= kRegressionSize
              ? systems.normals[r - kRegressionSize][c]
              : systems.moments[JetIndex(kMonomials.a[r] + kMonomials.a[c], kMonomials.b[r] + kMonomials.b[c])];
      DoubleVec rest = hn::Load(d, entry + i);
      CURVD_UNROLL(10)
      for (int k = 0; k < c; ++k) rest = hn::NegMulAdd(f.rows[r][k], f.rows[c][k], rest);
      f.rows[r][c] = hn::Mul(rest, inverse);
    }
    f.determined[kMonomials.a[c] + kMonomials.b[c]] = determined;
  }
}

// Solves the normal equations, each point in the highest degree, up to 3, whose monomials the neighbors tell apart.
HWY_INLINE FittedNormals FitNormals(const RegressionSystems& systems, size_t i) {
  const DoubleTag d;
  RegressionFactor f;
  FactorRegression(systems, i, f);
  DoubleVec solution[3][kRegressionSize];
  CURVD_UNROLL(3)
  for (int side = 0; side < 3; ++side) {
    CURVD_UNROLL(10)
    for (int c = kRegressionSize - 1; c >= 0; --c) {
      DoubleVec rest = f.rows[kRegressionSize + side][c];
      CURVD_UNROLL(10)
      for (int r = c + 1; r < kRegressionSize; ++r) rest = hn::NegMulAdd(f.rows[r][c], solution[side][r], rest);
      solution[side][c] =
          hn::IfThenElseZero(f.determined[kMonomials.a[c] + kMonomials.b[c]], hn::Mul(rest, f.rows[c][c]));
    }
  }
  DoubleVec degree = hn::Zero(d);
  for (int k = 1; k <= kRegressionDegree; ++k) {
    degree = hn::Add(degree, hn::IfThenElseZero(f.determined[k], hn::Set(d, 1.0)));
  }
  const auto coefficients = [&](int c) HWY_ATTR {
    return DoubleTriple{solution[0][c], solution[1][c], solution[2][c]};
  };
  return {coefficients(0), coefficients(1), coefficients(2), degree, f.doubtful};
}

// Solves the problems of points i, i + 1, ... and stores the shape operators of the fitted fields.
HWY_INLINE void SolveRegressionsAt(const GroupFrames& frames, size_t i, RegressionSystems& systems,
                                   GroupShapes& shapes) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
  const auto widen = [&](const GroupVectors& v) HWY_ATTR {
    return DoubleTriple{Widen(v.x + i), Widen(v.y + i), Widen(v.z + i)};
  };
  const DoubleTriple u = widen(frames.u), v = widen(frames.v);
  const DoubleTriple axis{hn::MulSub(u.y, v.z, hn::Mul(u.z, v.y)), hn::MulSub(u.z, v.x, hn::Mul(u.x, v.z)),
                          hn::MulSub(u.x, v.y, hn::Mul(u.y, v.x))};
  const FittedNormals fit = FitNormals(systems, i);
  const DoubleVec per_length = hn::Div(one, hn::Sqrt(Dot(fit.value, fit.value)));
  const DoubleTriple n = Scale(fit.value, per_length);
  ShapeOperator s;
  SetTangents(n, s);
  // Along a tangent t of unit length, x and y change by t u and t v. What the derivative has along n does not matter.
  const auto derivative = [&](const DoubleTriple& t) HWY_ATTR {
    return Scale(AddScaled(Scale(fit.by_x, Dot(t, u)), Dot(t, v), fit.by_y), per_length);
  };
  const DoubleTriple by_y = derivative(s.y), by_z = derivative(s.z);
  s.yy = Dot(by_y, s.y);
  s.yz = hn::Mul(half, hn::Add(Dot(by_y, s.z), Dot(by_z, s.y)));
  s.zz = Dot(by_z, s.z);
  StoreShapes(s, i, shapes);
  hn::Store(Dot(fit.value, axis), d, systems.outward + i);
  hn::Store(fit.degree, d, systems.degree + i);
  hn::Store(hn::IfThenElseZero(fit.doubtful, one), d, systems.doubtful + i);
}

// The highest degree that the neighbors of point i determine, which are `offsets`, given what they are off by from a
// polynomial of degree 3 over their tangent plane.
HWY_NOINLINE inline int RegressionDegree(const NeighborOffsets& offsets, const GroupFrames& frames, size_t i,
                                         const RegressionSystems& systems) {
  const PlaneAxes axes(frames, i);
  float normal[3];
  FrameNormal(frames, i, normal);
  const double unit = 1.0 / frames.rho[i];
  OffsetSums<kRegressionSize + 1> sums;
  for (size_t j = 0; j < offsets.count; ++j) {
    const double q[3] = {offsets.x[j], offsets.y[j], offsets.z[j]};
    const auto along = [&q](const auto* axis) { return q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2]; };
    const double x = along(axes.u), y = along(axes.v), z = along(normal) * unit;
    const double w = std::max(1.0 - x * x - y * y, 0.0);
    const double x_powers[4] = {1.0, x, x * x, x * x * x}, y_powers[4] = {1.0, y, y * y, y * y * y};
    for (int m = 0; m < kRegressionSize; ++m) {
      sums.Add(static_cast<size_t>(m), w * z * x_powers[kMonomials.a[m]] * y_powers[kMonomials.b[m]]);
    }
    sums.Add(kRegressionSize, w * z * z);
  }
  const double weight = systems.moments[0][i];
  double means[kRegressionMoments], heights[kRegressionSize];
  for (int m = 0; m < kRegressionMoments; ++m) means[m] = systems.moments[m][i] / weight;
  for (size_t m = 0; m < kRegressionSize; ++m) heights[m] = sums[m] / weight;
  return DeterminedDegree({kRegressionDegree, offsets.count, means, heights, sums[kRegressionSize] / weight});
}

// Lowers the degree of the fits that the neighbors do not determine, and solves those again. `searching` as of
// RefuseLines.
HWY_INLINE void LimitDegrees(const SpatialIndex& index, const NeighborhoodPlan& plan, GroupScratch& searching,
                             RegressionScratch& s) {
  constexpr size_t kNone = ~size_t{0};
  OffsetSearch search(index, plan, s.points, searching.search);
  size_t again = kNone;  // the first point of a vector that is to be solved again
  const auto solve_again = [&] HWY_ATTR {
    if (again != kNone) SolveRegressionsAt(s.frames, again, s.system, s.shapes);
    again = kNone;
  };
  for (size_t i = 0; i < s.points.size && !searching.IsStopped(); ++i) {
    if (i % hn::Lanes(DoubleTag()) == 0) solve_again();
    if (HWY_LIKELY(s.points.status[i] != PointStatus::kOk || s.system.doubtful[i] == 0.0)) continue;
    search.Find(i);
    const int degree = RegressionDegree(searching.search.offsets, s.frames, i, s.system);
    if (degree >= s.system.degree[i]) continue;
    s.system.most_degree[i] = degree;
    again = i - i % hn::Lanes(DoubleTag());
  }
  solve_again();
}

// Solves the problems of all points of the group, and stores their shapes. Lowers the status of points without a fit.
// `searching` as of RefuseLines.
HWY_NOINLINE inline void SolveRegressions(const SpatialIndex& index, const NeighborhoodPlan& plan,
                                          GroupScratch& searching, RegressionScratch& s) {
  GroupPoints& points = s.points;
  const RegressionSystems& systems = s.system;
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) {
    SolveRegressionsAt(s.frames, i, s.system, s.shapes);
  }
  LimitDegrees(index, plan, searching, s);
  for (size_t i = 0; i < points.size; ++i) {
    if (points.status[i] != PointStatus::kOk) continue;
    if (!(systems.degree[i] >= 1.0)) {
      points.status[i] = PointStatus::kSingularFit;
    } else if (!(systems.outward[i] >= kMinMeanNormal)) {
      points.status[i] = PointStatus::kInconsistentNormals;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_NORMAL_REGRESSION_INL_H_
