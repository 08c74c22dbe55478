// Local cubic regression of the normals (docs/numerics.md): each component of the neighbors' normals is fitted by a
// polynomial of degree 3 over the tangent plane (x, y), by least squares with weights w = 1 - (x^2 + y^2) / rho^2. The
// derivative of the fitted field over the surface's tangent plane at the point is its shape operator.

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
#include "core/estimators/neighbors.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// What a monomial adds to those before it, in square mean, is at least this fraction of its own square mean where the
// neighbors determine its coefficient.
inline constexpr double kMinRegressionPivot = 1e-6;
// Neighbors that spread less than the root of this in one tangent direction, compared with the other, lie on a line.
inline constexpr double kMinRegressionSpread = 1e-6;

// The neighbors of one point over its tangent plane, some of them at a time.
struct PlaneBlock {
  static constexpr size_t kSize = 256;
  alignas(64) double x[kSize];  // in units of rho
  alignas(64) double y[kSize];
  alignas(64) double w[kSize];  // weights; 0 for what pads the last vector
};

// Fills the block with `size` neighbors from `first` on.
HWY_INLINE void FillBlock(const NeighborArrays& n, size_t first, size_t size, const double* u, const double* v,
                          PlaneBlock& block) {
  const DoubleTag d;
  const DoubleTriple along_u{hn::Set(d, u[0]), hn::Set(d, u[1]), hn::Set(d, u[2])};
  const DoubleTriple along_v{hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
  const DoubleVec one = hn::Set(d, 1.0), zero = hn::Zero(d);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const size_t k = first + j;
    const DoubleTriple offset{Widen(n.dx.data() + k), Widen(n.dy.data() + k), Widen(n.dz.data() + k)};
    const DoubleVec x = Dot(offset, along_u), y = Dot(offset, along_v);
    const DoubleVec w = hn::Max(hn::NegMulAdd(y, y, hn::NegMulAdd(x, x, one)), zero);
    hn::Store(x, d, block.x + j);
    hn::Store(y, d, block.y + j);
    hn::Store(hn::IfThenElseZero(hn::FirstN(d, size - j), w), d, block.w + j);
  }
}

// The sums of one point, in the order of RegressionSystems.
struct RegressionSums {
  double moments[kRegressionMoments] = {};
  double normals[3][kRegressionSize] = {};
};

HWY_INLINE void SumBlock(const PlaneBlock& block, const NeighborArrays& n, size_t first, size_t size,
                         RegressionSums& sums) {
  const DoubleTag d;
  DoubleVec moments[kRegressionMoments], normals[3][kRegressionSize];
  for (DoubleVec& sum : moments) sum = hn::Zero(d);
  for (auto& component : normals) {
    for (DoubleVec& sum : component) sum = hn::Zero(d);
  }
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const DoubleVec x = hn::Load(d, block.x + j), y = hn::Load(d, block.y + j);
    const DoubleVec normal[3] = {Widen(n.nx.data() + first + j), Widen(n.ny.data() + first + j),
                                 Widen(n.nz.data() + first + j)};
    DoubleVec monomials[kRegressionMoments];
    monomials[0] = hn::Load(d, block.w + j);
    for (int k = 1; k <= 2 * kRegressionDegree; ++k) {
      for (int b = 0; b < k; ++b) monomials[JetIndex(k - b, b)] = hn::Mul(x, monomials[JetIndex(k - b - 1, b)]);
      monomials[JetIndex(0, k)] = hn::Mul(y, monomials[JetIndex(0, k - 1)]);
    }
    for (int m = 0; m < kRegressionMoments; ++m) moments[m] = hn::Add(moments[m], monomials[m]);
    for (int c = 0; c < 3; ++c) {
      for (int m = 0; m < kRegressionSize; ++m) normals[c][m] = hn::MulAdd(normal[c], monomials[m], normals[c][m]);
    }
  }
  for (int m = 0; m < kRegressionMoments; ++m) sums.moments[m] += hn::GetLane(hn::SumOfLanes(d, moments[m]));
  for (int c = 0; c < 3; ++c) {
    for (int m = 0; m < kRegressionSize; ++m) sums.normals[c][m] += hn::GetLane(hn::SumOfLanes(d, normals[c][m]));
  }
}

// Sets up the problem of point i, whose tangent frame is set, from its neighbors.
HWY_NOINLINE inline void SumNormals(const NeighborArrays& n, const GroupFrames& frames, size_t i,
                                    RegressionSystems& systems) {
  const double unit = 1.0 / frames.rho[i];
  const double u[3] = {frames.u.x[i] * unit, frames.u.y[i] * unit, frames.u.z[i] * unit};
  const double v[3] = {frames.v.x[i] * unit, frames.v.y[i] * unit, frames.v.z[i] * unit};
  RegressionSums sums;
  PlaneBlock block;
  for (size_t first = 0; first < n.count; first += PlaneBlock::kSize) {
    const size_t size = std::min(PlaneBlock::kSize, n.count - first);
    FillBlock(n, first, size, u, v, block);
    SumBlock(block, n, first, size, sums);
  }
  for (int m = 0; m < kRegressionMoments; ++m) systems.moments[m][i] = sums.moments[m];
  for (int c = 0; c < 3; ++c) {
    for (int m = 0; m < kRegressionSize; ++m) systems.normals[c][m][i] = sums.normals[c][m];
  }
}

// Value and derivatives by x and y, at the point, of the polynomials that fit the normals' components.
struct FittedNormals {
  DoubleTriple value, by_x, by_y;
  DoubleVec degree;
};

// Solves the normal equations of points i, i + 1, ... by Cholesky's method, each in the highest degree, up to 3, whose
// monomials the neighbors tell apart. The factor of a lower degree is a part of that of a higher one.
HWY_INLINE FittedNormals FitNormals(const RegressionSystems& systems, size_t i) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), zero = hn::Zero(d), least = hn::Set(d, kMinRegressionPivot);
  DoubleVec rows[kRegressionSize + 3][kRegressionSize];  // the lower triangle, diagonals inverted, and the right sides
  DoubleMask determined = hn::Gt(hn::Load(d, systems.moments[0] + i), zero);
  DoubleVec degree = zero;
  struct Powers {
    int a, b;
  } powers[kRegressionSize];
  for (int k = 0; k <= kRegressionDegree; ++k) {
    for (int b = 0; b <= k; ++b) powers[JetIndex(k - b, b)] = {k - b, b};
  }
  DoubleMask of_degree[kRegressionDegree + 1];
  DoubleVec x_spread = zero;
  for (int c = 0; c < kRegressionSize; ++c) {
    const auto entry = [&](int r) HWY_ATTR {
      return hn::Load(
          d, (r >= kRegressionSize ? systems.normals[r - kRegressionSize][c]
                                   : systems.moments[JetIndex(powers[r].a + powers[c].a, powers[r].b + powers[c].b)]) +
                 i);
    };
    DoubleVec inverse = zero;
    for (int r = c; r < kRegressionSize + 3; ++r) {
      DoubleVec rest = entry(r);
      for (int k = 0; k < c; ++k) rest = hn::NegMulAdd(rows[r][k], rows[c][k], rest);
      if (r == c) {
        const DoubleVec bound = hn::Mul(least, entry(r));
        determined = hn::And(determined, hn::Gt(rest, bound));
        if (c == JetIndex(1, 0)) x_spread = rest;
        if (c == JetIndex(0, 1)) {
          // Pivots of x and of y beside x: their product is the determinant of the covariance.
          const DoubleVec y_spread = hn::MulAdd(rows[c][1], rows[c][1], rest), trace = hn::Add(x_spread, y_spread);
          const DoubleVec narrow = hn::Mul(hn::Set(d, kMinRegressionSpread), hn::Mul(trace, trace));
          determined = hn::And(determined, hn::Gt(hn::Mul(x_spread, rest), narrow));
        }
        inverse = hn::Div(one, hn::Sqrt(hn::Max(rest, bound)));
        rows[c][c] = inverse;
      } else {
        rows[r][c] = hn::Mul(rest, inverse);
      }
    }
    const int k = powers[c].a + powers[c].b;
    of_degree[k] = determined;
    if (powers[c].a == 0) degree = hn::IfThenElse(determined, hn::Set(d, static_cast<double>(k)), degree);
  }
  DoubleVec solution[3][kRegressionSize];
  for (int side = 0; side < 3; ++side) {
    for (int c = kRegressionSize - 1; c >= 0; --c) {
      DoubleVec rest = rows[kRegressionSize + side][c];
      for (int r = c + 1; r < kRegressionSize; ++r) rest = hn::NegMulAdd(rows[r][c], solution[side][r], rest);
      solution[side][c] = hn::IfThenElseZero(of_degree[powers[c].a + powers[c].b], hn::Mul(rest, rows[c][c]));
    }
  }
  const auto coefficients = [&](int c) { return DoubleTriple{solution[0][c], solution[1][c], solution[2][c]}; };
  return {coefficients(0), coefficients(1), coefficients(2), degree};
}

// Solves the problems of points i, i + 1, ... and stores the shape operators of the fitted fields.
HWY_INLINE void SolveNormalsAt(const GroupFrames& frames, size_t i, RegressionSystems& systems, GroupShapes& shapes) {
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
}

// Shapes of all points of the group, whose problems are set up. Lowers the status of points without a fit.
HWY_NOINLINE inline void SolveNormals(const GroupFrames& frames, GroupPoints& points, RegressionSystems& systems,
                                      GroupShapes& shapes) {
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) SolveNormalsAt(frames, i, systems, shapes);
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
