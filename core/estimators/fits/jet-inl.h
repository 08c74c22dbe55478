// Jets (Cazals, Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2005): a
// polynomial as height over the plane in which the neighbors lie best, by least squares. Normal equations, whose matrix
// holds few different moments, solve nearly every point to full precision; where they would lose digits, the point is
// left to core/estimators/fits/jet_least_squares.h.

#if defined(CURVD_CORE_ESTIMATORS_FITS_JET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_JET_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_JET_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_JET_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/fits/jet_least_squares.h"
#include "core/estimators/fits/least_axis.h"
#include "core/estimators/fits/quadric_sums-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/lines/curve_distance.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A pivot of the normal equations relative to the number of neighbors, with offsets in units of rho, is the mean square
// of what one monomial adds to those before it. Above this one, coefficients are good to 1e-9 (docs/numerics.md).
inline constexpr double kMinJetPivot = 1e-6;

// How the neighbors of a point lie around it, in units of rho.
struct NeighborSpread {
  double mean[3];        // offset
  double squares[6];     // mean products of offsets: xx xy xz yy yz zz
  double covariance[6];  // the same about the mean
};

HWY_INLINE NeighborSpread MeasureSpread(const NeighborArrays& n, double unit) {
  const DoubleTag d;
  const DoubleVec scale = hn::Set(d, unit), anchor = hn::Set(d, AnchorOf(n.count));
  DoubleVec sx = anchor, sy = sx, sz = sx, xx = sx, xy = sx, xz = sx, yy = sx, yz = sx, zz = sx;
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const DoubleVec x = OddProduct(Widen(n.dx.data() + j), scale);
    const DoubleVec y = OddProduct(Widen(n.dy.data() + j), scale);
    const DoubleVec z = OddProduct(Widen(n.dz.data() + j), scale);
    sx = hn::Add(sx, x), sy = hn::Add(sy, y), sz = hn::Add(sz, z);
    xx = AddProduct(x, x, xx, anchor), xy = AddProduct(x, y, xy, anchor), xz = AddProduct(x, z, xz, anchor);
    yy = AddProduct(y, y, yy, anchor), yz = AddProduct(y, z, yz, anchor), zz = AddProduct(z, z, zz, anchor);
  }
  double sums[12];
  StoreAnchoredSums(sx, sy, sz, xx, anchor, sums);
  StoreAnchoredSums(xy, xz, yy, yz, anchor, sums + 4);
  StoreAnchoredSums(zz, zz, zz, zz, anchor, sums + 8);
  const double per_count = 1.0 / static_cast<double>(n.count);
  NeighborSpread spread;
  for (int axis = 0; axis < 3; ++axis) spread.mean[axis] = sums[axis] * per_count;
  for (int entry = 0; entry < 6; ++entry) spread.squares[entry] = sums[3 + entry] * per_count;
  for (int a = 0, entry = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b, ++entry) {
      spread.covariance[entry] = spread.squares[entry] - spread.mean[a] * spread.mean[b];
    }
  }
  return spread;
}

// Sets the fitting frame of point i: `axis` is the direction in which the neighbors spread least.
HWY_INLINE void SetJetFrame(const NeighborSpread& spread, size_t i, JetSystems& jets) {
  double axis[3];
  LeastAxis(spread.covariance, axis);
  // The fit is the same for any two axes of the plane (Duff et al., "Building an orthonormal basis, revisited", 2017).
  const double sign = std::copysign(1.0, axis[2]);
  const double a = -1.0 / (sign + axis[2]), b = axis[0] * axis[1] * a;
  const double u[3] = {1.0 + sign * axis[0] * axis[0] * a, sign * b, -sign * axis[0]};
  const double v[3] = {b, sign + axis[1] * axis[1] * a, -axis[1]};
  jets.u.Set(i, u);
  jets.v.Set(i, v);
  jets.axis.Set(i, axis);
}

// The columns of one jet: 1, x .. x^2d, y .. y^2d, z, z x .. z x^d for degree d.
struct JetColumns {
  int degree;
  const double* one;
  double* x[2 * kMaxFittedDegree + 1];  // by power
  double* y[2 * kMaxFittedDegree + 1];
  double* zx[kMaxFittedDegree + 1];

  JetColumns(int jet_degree, size_t size, FitColumns& fits) : degree(jet_degree) {
    const size_t powers = 2 * static_cast<size_t>(degree);
    fits.Reserve(JetColumnCount(degree), size);
    size_t next = 0;
    one = x[0] = y[0] = fits.column(next++);
    for (size_t p = 1; p <= powers; ++p) x[p] = fits.column(next++);
    for (size_t p = 1; p <= powers; ++p) y[p] = fits.column(next++);
    for (int p = 0; p <= degree; ++p) zx[p] = fits.column(next++);
  }
};

// Fills the columns with neighbors [first, last) of point i in its fitting frame. All but the ones are Odd.
HWY_INLINE void FillJetColumns(const NeighborArrays& n, size_t first, size_t last, double unit, size_t i,
                               const JetSystems& jets, const JetColumns& columns) {
  const DoubleTag d;
  const auto axis = [&](const GroupDoubleVectors& v) {
    return DoubleTriple{hn::Set(d, v.x[i] * unit), hn::Set(d, v.y[i] * unit), hn::Set(d, v.z[i] * unit)};
  };
  const DoubleTriple u = axis(jets.u), v = axis(jets.v), w = axis(jets.axis);
  for (size_t k = 0; first + k < last; k += hn::Lanes(d)) {
    const size_t j = first + k;
    const DoubleTriple offset{Widen(n.dx.data() + j), Widen(n.dy.data() + j), Widen(n.dz.data() + j)};
    const DoubleVec x = Odd(Dot(offset, u)), y = Odd(Dot(offset, v)), z = Odd(Dot(offset, w));
    DoubleVec xp = x, yp = y, zxp = z;
    hn::Store(hn::Set(d, 1.0), d, columns.x[0] + k);
    for (int p = 1; p <= 2 * columns.degree; ++p) {
      hn::Store(xp, d, columns.x[p] + k);
      hn::Store(yp, d, columns.y[p] + k);
      xp = WithLastBit(hn::Mul(xp, x));
      yp = WithLastBit(hn::Mul(yp, y));
    }
    for (int p = 0; p <= columns.degree; ++p) {
      hn::Store(zxp, d, columns.zx[p] + k);
      zxp = WithLastBit(hn::Mul(zxp, x));
    }
  }
}

// Adds the sums of left[a] y^b over the first `count` numbers of the columns, for all a + b <= degree, to
// out[JetIndex(a, b)][i].
HWY_INLINE void AddSums(double* const* left, int degree, const JetColumns& columns, size_t count, DoubleVec anchor,
                        size_t i, GroupDoubles* out) {
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; b <= degree - a; b += 4) {
      FourColumns right;
      for (int k = 0; k < 4; ++k) right.column[k] = b + k <= degree - a ? columns.y[b + k] : columns.one;
      double sums[4];
      DotFour(left[a], right, count, anchor, sums);
      for (int k = 0; k < std::min(4, degree - a - b + 1); ++k) out[JetIndex(a, b + k)][i] += sums[k];
    }
  }
}

// Sets up the least squares problem of point i, whose fitting frame is set, from its neighbors.
HWY_INLINE void SumJetInFrame(const NeighborArrays& n, double unit, int degree, size_t i, FitColumns& column_room,
                              JetSystems& jets) {
  const JetColumns columns(degree, std::min(n.count, kMostInJetColumns), column_room);
  // Sums that began at one anchor are exact in its quanta, and so are their sums.
  const DoubleVec anchor = hn::Set(DoubleTag(), AnchorOf(n.count));
  for (int m = 0; m < JetSize(2 * degree); ++m) jets.moments[m][i] = 0.0;
  for (int m = 0; m < JetSize(degree); ++m) jets.heights[m][i] = 0.0;
  jets.squared_heights[i] = 0.0;
  for (size_t first = 0; first < n.count; first += kMostInJetColumns) {
    const size_t count = std::min(n.count - first, kMostInJetColumns);
    FillJetColumns(n, first, first + count, unit, i, jets, columns);
    AddSums(columns.x, 2 * degree, columns, count, anchor, i, jets.moments);
    AddSums(columns.zx, degree, columns, count, anchor, i, jets.heights);
    double squares[4];
    DotFour(columns.zx[0], {{columns.zx[0], columns.zx[0], columns.zx[0], columns.zx[0]}}, count, anchor, squares);
    jets.squared_heights[i] += squares[0];
  }
  jets.moments[0][i] = static_cast<double>(n.count);  // the sum of ones counts the padding
}

// Sets the fitting frame of point i, and sets up its least squares problem, from its neighbors.
HWY_NOINLINE inline void SumJet(const NeighborArrays& n, float rho, int degree, size_t i, FitColumns& column_room,
                                JetSystems& jets) {
  const double unit = 1.0 / rho;
  SetJetFrame(MeasureSpread(n, unit), i, jets);
  if (degree == 2) return SumAnchoredQuadricInFrame(n, unit, i, jets);
  SumJetInFrame(n, unit, degree, i, column_room, jets);
}

// Solves the normal equations of points i, i + 1, ... by Cholesky's method.
HWY_INLINE void SolveNormalEquations(int degree, size_t i, JetSystems& jets) {
  const DoubleTag d;
  constexpr size_t kLanes = SpatialIndex::kLeafSize / 2;
  // The lower triangle, diagonals inverted, and the right side as one more row.
  alignas(64) double rows[kMaxJetSize + 1][kMaxJetSize][kLanes];
  const int size = JetSize(degree);
  const DoubleVec least = hn::Mul(hn::Load(d, jets.moments[0] + i), hn::Set(d, kMinJetPivot));
  DoubleVec least_pivot = hn::Load(d, jets.moments[0] + i);
  struct Powers {
    int a, b;
  } powers[kMaxJetSize];
  for (int k = 0; k <= degree; ++k) {
    for (int b = 0; b <= k; ++b) powers[JetIndex(k - b, b)] = {k - b, b};
  }
  for (int c = 0; c < size; ++c) {
    DoubleVec inverse = hn::Zero(d);
    for (int r = c; r <= size; ++r) {
      const double* entry =
          r == size ? jets.heights[c] : jets.moments[JetIndex(powers[r].a + powers[c].a, powers[r].b + powers[c].b)];
      DoubleVec rest = hn::Load(d, entry + i);
      for (int k = 0; k < c; ++k) rest = hn::NegMulAdd(hn::Load(d, rows[r][k]), hn::Load(d, rows[c][k]), rest);
      if (r == c) {
        least_pivot = hn::Min(least_pivot, rest);
        inverse = hn::Div(hn::Set(d, 1.0), hn::Sqrt(hn::Max(rest, least)));
        hn::Store(inverse, d, rows[c][c]);
      } else {
        hn::Store(hn::Mul(rest, inverse), d, rows[r][c]);
      }
    }
  }
  for (int c = size - 1; c >= 0; --c) {
    DoubleVec rest = hn::Load(d, rows[size][c]);
    for (int r = c + 1; r < size; ++r) {
      rest = hn::NegMulAdd(hn::Load(d, rows[r][c]), hn::Load(d, jets.coefficients[r] + i), rest);
    }
    hn::Store(hn::Mul(rest, hn::Load(d, rows[c][c])), d, jets.coefficients[c] + i);
  }
  hn::Store(least_pivot, d, jets.least_pivot + i);
}

// Shape operators of the surfaces of points i, i + 1, ..., above each point, with the point's normal outward.
HWY_INLINE void StoreJetShapes(const GroupVectors& normals, size_t i, const JetSystems& jets, GroupShapes& out) {
  const DoubleTag d;
  const auto coefficient = [&](int a, int b) { return hn::Load(d, jets.coefficients[JetIndex(a, b)] + i); };
  const DoubleVec one = hn::Set(d, 1.0);
  const DoubleTriple u = LoadTriple(jets.u, i), v = LoadTriple(jets.v, i), axis = LoadTriple(jets.axis, i);
  // Slopes a, b; first fundamental form E, F, G; second l, m, n over the length of the normal (-a, -b, 1).
  const DoubleVec a = coefficient(1, 0), b = coefficient(0, 1);
  const DoubleVec E = hn::MulAdd(a, a, one), F = hn::Mul(a, b), G = hn::MulAdd(b, b, one);
  const DoubleVec l = hn::Add(coefficient(2, 0), coefficient(2, 0)), m = coefficient(1, 1);
  const DoubleVec n = hn::Add(coefficient(0, 2), coefficient(0, 2));
  const DoubleVec squared = hn::NegMulAdd(F, F, hn::Mul(E, G)), length = hn::Sqrt(squared);
  const DoubleTriple normal = AddScaled(AddScaled(axis, hn::Neg(a), u), hn::Neg(b), v);
  const DoubleTriple own{Widen(normals.x + i), Widen(normals.y + i), Widen(normals.z + i)};
  // A surface that bends toward the axis has l, m, n > 0, and negative curvature if the axis is outward.
  const DoubleVec outward = hn::CopySign(one, Dot(normal, own));
  const DoubleVec side = hn::Neg(outward);
  // Gram-Schmidt on the tangents u + a axis and v + b axis.
  const DoubleVec root = hn::Sqrt(E);
  const DoubleTriple y = Scale(AddScaled(u, a, axis), hn::Div(one, root));
  const DoubleTriple z = Scale(AddScaled(Scale(AddScaled(v, b, axis), E), hn::Neg(F), AddScaled(u, a, axis)),
                               hn::Div(outward, hn::Mul(root, length)));
  ShapeOperator s;
  s.y = y;
  s.z = z;
  s.yy = hn::Div(hn::Mul(side, l), hn::Mul(length, E));
  s.yz = hn::Div(hn::NegMulAdd(F, l, hn::Mul(E, m)), hn::Neg(hn::Mul(squared, E)));
  const DoubleVec zz = hn::MulAdd(F, hn::NegMulAdd(hn::Add(m, m), E, hn::Mul(F, l)), hn::Mul(hn::Mul(E, E), n));
  s.zz = hn::Div(hn::Mul(side, zz), hn::Mul(hn::Mul(squared, length), E));
  StoreShapes(s, i, out);
}

// Least pivots below this may be of neighbors that lie near a curve; by degree. Those of an even disc are 16 times as
// large (of degrees 3 and 4, that of the last monomial), at the rim of a surface as large or less from degree 3 on.
inline constexpr double kDoubtfulJetPivot[kMaxFittedDegree + 1] = {0.0, 0.0, 3.5e-3, 8e-4, 1.8e-4, 1.2e-5, 2e-6};

// The highest degree up to which the neighbors of point i, whose sums are set, determine a jet
// (core/estimators/lines/curve_distance.h).
HWY_NOINLINE inline int DeterminedJetDegree(int degree, size_t i, const JetSystems& jets) {
  double means[kMaxJetMoments], heights[kMaxJetSize];
  const double count = jets.moments[0][i];
  for (int m = 0; m < JetSize(2 * degree); ++m) means[m] = jets.moments[m][i] / count;
  for (int m = 0; m < JetSize(degree); ++m) heights[m] = jets.heights[m][i] / count;
  return DeterminedDegree({degree, static_cast<size_t>(count), means, heights, jets.squared_heights[i] / count});
}

// Solves for a jet of the highest degree up to `most` for which the neighbors of point i do, in the place of one of
// `degree`. Returns false if there is none.
HWY_NOINLINE inline bool SolveLowerJet(const NeighborArrays& neighbors, size_t i, double unit, int most, int degree,
                                       ScratchArray<double>& qr_room, JetSystems& jets) {
  for (int lower = most; lower > 0; --lower) {
    if (!SolveJetByQr(neighbors, i, unit, lower, qr_room, jets)) continue;
    for (int c = JetSize(lower); c < JetSize(degree); ++c) jets.coefficients[c][i] = 0.0;
    return true;
  }
  return false;
}

// Solves the problems of all points of the group. `find(i)` collects the neighbors of point i as `neighbors` once more,
// where that is needed; `qr_room` is scratch for those. Where it returns false, no point from there on has a jet.
// Lowers the status of points without a jet; with kNeedsCurvature also that of points whose jets noise decides. With
// `lowers_degree`, where only normals are wanted, points whose neighbors determine no jet of the degree get one of a
// lower degree; `without_noise`: so do those whose neighbors determine it by their noise alone. Where noise matters,
// squared_heights must be set.
template <bool kNeedsCurvature, typename FindNeighbors>
HWY_NOINLINE void SolveJetSystems(int degree, const GroupScalars& rho, const NeighborArrays& neighbors,
                                  ScratchArray<double>& qr_room, GroupPoints& points, JetSystems& jets,
                                  FindNeighbors find, bool lowers_degree = false, bool without_noise = false) {
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) SolveNormalEquations(degree, i, jets);
  for (size_t i = 0; i < points.size; ++i) {
    if (points.status[i] != PointStatus::kOk) continue;
    const double pivot = jets.least_pivot[i] / jets.moments[0][i];
    const bool is_doubtful = (kNeedsCurvature || without_noise) && pivot < kDoubtfulJetPivot[degree];
    int determined = HWY_UNLIKELY(is_doubtful) ? DeterminedJetDegree(degree, i, jets) : degree;
    // A plane would be worse than what noise decides in part.
    if (!kNeedsCurvature && determined < 2) determined = degree;
    if (kNeedsCurvature && determined < degree) {
      points.status[i] = PointStatus::kSingularFit;
      continue;
    }
    if (pivot > kMinJetPivot && determined == degree) continue;
    if (!find(i)) break;
    const double unit = 1.0 / rho[i];
    if (determined == degree && SolveJetByQr(neighbors, i, unit, degree, qr_room, jets)) continue;
    const int most = std::min(determined, degree - 1);
    if (lowers_degree && SolveLowerJet(neighbors, i, unit, most, degree, qr_room, jets)) continue;
    points.status[i] = PointStatus::kSingularFit;
  }
}

// The same, and the shapes of the jets.
template <typename FindNeighbors>
HWY_NOINLINE void SolveJets(int degree, const GroupScalars& rho, const NeighborArrays& neighbors,
                            ScratchArray<double>& qr_room, GroupPoints& points, JetSystems& jets, GroupShapes& shapes,
                            FindNeighbors find) {
  SolveJetSystems</*kNeedsCurvature=*/true>(degree, rho, neighbors, qr_room, points, jets, find);
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) StoreJetShapes(points.normal, i, jets, shapes);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_JET_INL_H_
