// Fits to few neighbors, of as many points at once as a vector of doubles has lanes: sums over the neighbors of one
// point would spend more on adding up lanes than on neighbors.

#if defined(CURVD_CORE_NORMALS_FITS_LANE_FITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_NORMALS_FITS_LANE_FITS_INL_H_
#undef CURVD_CORE_NORMALS_FITS_LANE_FITS_INL_H_
#else
#define CURVD_CORE_NORMALS_FITS_LANE_FITS_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/normals/fits/normal_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Neighbors that spread less than this in their middle direction, compared with the widest and squared, lie on a line.
inline constexpr double kMinLineSpread = 1e-6;
// A point whose neighbors' mean is farther away than this many times their spread, squared, lies by itself. In the tip
// of a wedge, however narrow, it is 8 times.
inline constexpr double kMaxSeclusion = 12.0;

// Symmetric matrices, a lane each.
struct SymmetricLanes {
  DoubleVec xx, xy, xz, yy, yz, zz;
};

// x' m y
HWY_INLINE DoubleVec ProductOf(const DoubleTriple& x, const SymmetricLanes& m, const DoubleTriple& y) {
  const DoubleTriple product{Dot({m.xx, m.xy, m.xz}, y), Dot({m.xy, m.yy, m.yz}, y), Dot({m.xz, m.yz, m.zz}, y)};
  return Dot(x, product);
}

HWY_INLINE DoubleTriple CrossOf(const DoubleTriple& a, const DoubleTriple& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}

// The unit eigenvectors of the smallest eigenvalues; along z where all are equal. The eigenvalue is the least root of
// the characteristic polynomial of the matrix less its mean eigenvalue, t^3 - 3 s^2 t - det, which lies between -2 s
// and -s. From -2 s on, where the polynomial rises and is concave, Newton's steps come to it from below, however near
// the next root is.
HWY_INLINE DoubleTriple LeastAxes(const SymmetricLanes& m) {
  const DoubleTag d;
  constexpr int kMostSteps = 60;  // between two roots that are one, each step halves the way
  constexpr double kEnough = 0x1p-50;
  const DoubleVec zero = hn::Zero(d), one = hn::Set(d, 1.0), three = hn::Set(d, 3.0);
  const DoubleVec mean = hn::Div(hn::Add(hn::Add(m.xx, m.yy), m.zz), three);
  const DoubleVec xx = hn::Sub(m.xx, mean), yy = hn::Sub(m.yy, mean), zz = hn::Sub(m.zz, mean);
  const DoubleVec beside = Dot({m.xy, m.xz, m.yz}, {m.xy, m.xz, m.yz});
  const DoubleVec squared = hn::Div(hn::Add(Dot({xx, yy, zz}, {xx, yy, zz}), hn::Add(beside, beside)), hn::Set(d, 6.0));
  const DoubleVec determinant = Dot({xx, m.xy, m.xz}, CrossOf({m.xy, yy, m.yz}, {m.xz, m.yz, zz}));
  const DoubleVec spread = hn::Sqrt(squared), negligible = hn::Mul(spread, hn::Set(d, kEnough));
  DoubleVec root = hn::Mul(spread, hn::Set(d, -2.0));
  // A lane stops where it has come near enough, whatever the others do: a point's normal does not depend on them.
  DoubleMask moves = hn::Gt(spread, zero);
  for (int step = 0; step < kMostSteps; ++step) {
    const DoubleVec from_squared = hn::MulSub(root, root, squared);  // root^2 - s^2
    const DoubleVec value = hn::MulSub(root, hn::Sub(from_squared, hn::Add(squared, squared)), determinant);
    const DoubleVec slope = hn::Mul(three, from_squared);
    moves = hn::And(moves, hn::Gt(slope, zero));
    const DoubleVec change = hn::IfThenElseZero(moves, hn::Div(value, slope));
    root = hn::Sub(root, change);
    moves = hn::And(moves, hn::Gt(hn::Abs(change), negligible));
    if (hn::AllFalse(d, moves)) break;
  }
  // The axis is normal to all rows of the matrix less the eigenvalue; the longest product of two is the most exact.
  const DoubleTriple x{hn::Sub(xx, root), m.xy, m.xz}, y{m.xy, hn::Sub(yy, root), m.yz},
      z{m.xz, m.yz, hn::Sub(zz, root)};
  DoubleTriple longest{zero, zero, one};
  DoubleVec length = zero;
  const auto offer = [&](const DoubleTriple& product) HWY_ATTR {
    const DoubleVec squared_product = Dot(product, product);
    const DoubleMask is_longer = hn::Gt(squared_product, length);
    longest = {hn::IfThenElse(is_longer, product.x, longest.x), hn::IfThenElse(is_longer, product.y, longest.y),
               hn::IfThenElse(is_longer, product.z, longest.z)};
    length = hn::IfThenElse(is_longer, squared_product, length);
  };
  offer(CrossOf(x, y));
  offer(CrossOf(y, z));
  offer(CrossOf(z, x));
  length = hn::IfThenElse(hn::Gt(length, zero), length, one);
  return Scale(longest, hn::Div(one, hn::Sqrt(length)));
}

// Copies the neighbors of point i, which is the one of the moment, to its lane.
HWY_INLINE void TakeLane(const NeighborArrays& n, size_t i, LaneNeighbors& out) {
  const size_t lanes = hn::Lanes(DoubleTag()), lane = i % lanes;
  for (size_t j = 0; j < n.count; ++j) {
    out.x[j * lanes + lane] = n.dx[j];
    out.y[j * lanes + lane] = n.dy[j];
    out.z[j * lanes + lane] = n.dz[j];
  }
}

// How the neighbors of some points lie around them, in units of rho.
struct SpreadLanes {
  DoubleTriple mean;          // offset
  SymmetricLanes squares;     // mean products of offsets
  SymmetricLanes covariance;  // the same about the mean
};

HWY_INLINE SpreadLanes MeasureLanes(const LaneNeighbors& n, size_t count, DoubleVec unit) {
  const DoubleTag d;
  const size_t lanes = hn::Lanes(d);
  const DoubleVec zero = hn::Zero(d);
  DoubleTriple sum{zero, zero, zero};
  SymmetricLanes q{zero, zero, zero, zero, zero, zero};
  for (size_t j = 0; j < count * lanes; j += lanes) {
    const DoubleVec x = hn::Mul(Widen(n.x + j), unit), y = hn::Mul(Widen(n.y + j), unit);
    const DoubleVec z = hn::Mul(Widen(n.z + j), unit);
    sum.x = hn::Add(sum.x, x), sum.y = hn::Add(sum.y, y), sum.z = hn::Add(sum.z, z);
    q.xx = hn::MulAdd(x, x, q.xx), q.xy = hn::MulAdd(x, y, q.xy), q.xz = hn::MulAdd(x, z, q.xz);
    q.yy = hn::MulAdd(y, y, q.yy), q.yz = hn::MulAdd(y, z, q.yz), q.zz = hn::MulAdd(z, z, q.zz);
  }
  const DoubleVec per_count = hn::Set(d, 1.0 / static_cast<double>(count));
  const DoubleTriple mean = Scale(sum, per_count);
  const auto scaled = [&](DoubleVec v) HWY_ATTR { return hn::Mul(v, per_count); };
  const SymmetricLanes s{scaled(q.xx), scaled(q.xy), scaled(q.xz), scaled(q.yy), scaled(q.yz), scaled(q.zz)};
  const auto about = [&](DoubleVec v, DoubleVec a, DoubleVec b) HWY_ATTR { return hn::NegMulAdd(a, b, v); };
  return {mean,
          s,
          {about(s.xx, mean.x, mean.x), about(s.xy, mean.x, mean.y), about(s.xz, mean.x, mean.z),
           about(s.yy, mean.y, mean.y), about(s.yz, mean.y, mean.z), about(s.zz, mean.z, mean.z)}};
}

// Sums x^a y^b over the neighbors, for kFirst <= a <= kLast and all b with a + b <= kDegree, to
// out[JetIndex(a, b)][i, ...]; times `left`, unless it is null.
template <int kDegree, int kFirst, int kLast>
HWY_INLINE void SumLanePowers(const double* left, const double* x, const double* y, size_t count, size_t i,
                              GroupDoubles* out) {
  const DoubleTag d;
  const size_t lanes = hn::Lanes(d);
  DoubleVec sums[kLast - kFirst + 1][kDegree + 1 - kFirst];
#pragma GCC unroll 9
  for (int a = kFirst; a <= kLast; ++a) {
#pragma GCC unroll 9
    for (int b = 0; b <= kDegree - a; ++b) sums[a - kFirst][b] = hn::Zero(d);
  }
  for (size_t j = 0; j < count * lanes; j += lanes) {
    const DoubleVec xj = hn::Load(d, x + j), yj = hn::Load(d, y + j);
    DoubleVec power = left == nullptr ? hn::Set(d, 1.0) : hn::Load(d, left + j);
#pragma GCC unroll 9
    for (int a = 0; a < kFirst; ++a) power = hn::Mul(power, xj);
    DoubleVec y_powers[kDegree + 1 - kFirst];
    y_powers[0] = hn::Set(d, 1.0);
#pragma GCC unroll 9
    for (int b = 1; b <= kDegree - kFirst; ++b) y_powers[b] = hn::Mul(y_powers[b - 1], yj);
#pragma GCC unroll 9
    for (int a = kFirst; a <= kLast; ++a) {
      sums[a - kFirst][0] = hn::Add(sums[a - kFirst][0], power);
#pragma GCC unroll 9
      for (int b = 1; b <= kDegree - a; ++b) {
        sums[a - kFirst][b] = hn::MulAdd(power, y_powers[b], sums[a - kFirst][b]);
      }
      if (a < kLast) power = hn::Mul(power, xj);
    }
  }
#pragma GCC unroll 9
  for (int a = kFirst; a <= kLast; ++a) {
#pragma GCC unroll 9
    for (int b = 0; b <= kDegree - a; ++b) hn::Store(sums[a - kFirst][b], d, out[JetIndex(a, b)] + i);
  }
}

// Sets up the least squares problems of points i, i + 1, ..., whose frames these are.
HWY_INLINE void SumLanes(int degree, const DoubleTriple& u, const DoubleTriple& v, const DoubleTriple& axis,
                         DoubleVec unit, size_t count, size_t i, LaneNeighbors& n, JetSystems& jets) {
  const DoubleTag d;
  const size_t lanes = hn::Lanes(d);
  const DoubleTriple x_axis = Scale(u, unit), y_axis = Scale(v, unit), z_axis = Scale(axis, unit);
  for (size_t j = 0; j < count * lanes; j += lanes) {
    const DoubleTriple offset{Widen(n.x + j), Widen(n.y + j), Widen(n.z + j)};
    hn::Store(Dot(offset, x_axis), d, n.in_frame[0] + j);
    hn::Store(Dot(offset, y_axis), d, n.in_frame[1] + j);
    hn::Store(Dot(offset, z_axis), d, n.in_frame[2] + j);
  }
  const double *x = n.in_frame[0], *y = n.in_frame[1], *z = n.in_frame[2];
  // As many sums at a time as registers hold.
  if (degree == 4) {
    SumLanePowers<8, 0, 2>(nullptr, x, y, count, i, jets.moments);
    SumLanePowers<8, 3, 8>(nullptr, x, y, count, i, jets.moments);
    SumLanePowers<4, 0, 4>(z, x, y, count, i, jets.heights);
  } else if (degree == 2) {
    SumLanePowers<4, 0, 4>(nullptr, x, y, count, i, jets.moments);
    SumLanePowers<2, 0, 2>(z, x, y, count, i, jets.heights);
  } else {
    SumLanePowers<2, 0, 2>(nullptr, x, y, count, i, jets.moments);
    SumLanePowers<1, 0, 1>(z, x, y, count, i, jets.heights);
  }
}

// Sets the frames of points i, i + 1, ..., and what the spread of their neighbors says about the planes in which they
// lie best, as SetPlane does for one; lowers the status of those without; sets up their least squares problems.
// REQUIRES: all whose status is kOk have `count` neighbors, of which the lanes hold the offsets.
HWY_NOINLINE inline void FitLanes(int degree, size_t count, size_t i, NormalScratch& s) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), zero = hn::Zero(d), half = hn::Set(d, 0.5);
  const DoubleVec unit = hn::Div(one, Widen(s.frames.rho + i));
  const SpreadLanes spread = MeasureLanes(s.lanes, count, unit);
  const DoubleTriple axis = LeastAxes(spread.covariance);
  // As SetJetFrame.
  const DoubleVec sign = hn::CopySign(one, axis.z);
  const DoubleVec a = hn::Neg(hn::Div(one, hn::Add(sign, axis.z))), b = hn::Mul(hn::Mul(axis.x, axis.y), a);
  const DoubleTriple u{hn::MulAdd(hn::Mul(sign, axis.x), hn::Mul(axis.x, a), one), hn::Mul(sign, b),
                       hn::Neg(hn::Mul(sign, axis.x))};
  const DoubleTriple v{b, hn::MulAdd(hn::Mul(axis.y, axis.y), a, sign), hn::Neg(axis.y)};
  StoreTriple(u, i, s.system.u);
  StoreTriple(v, i, s.system.v);
  StoreTriple(axis, i, s.system.axis);
  StoreTriple(axis, i, s.normal);

  const DoubleVec uu = ProductOf(u, spread.covariance, u), uv = ProductOf(u, spread.covariance, v);
  const DoubleVec vv = ProductOf(v, spread.covariance, v);
  const DoubleVec difference = hn::Mul(half, hn::Sub(uu, vv)), mean = hn::Mul(half, hn::Add(uu, vv));
  const DoubleVec root = hn::Sqrt(hn::MulAdd(difference, difference, hn::Mul(uv, uv)));
  const DoubleVec widest = hn::Add(mean, root), middle = hn::Sub(mean, root);
  const DoubleVec least = hn::Max(ProductOf(axis, spread.covariance, axis), zero);
  hn::Store(least, d, s.mean_square + i);
  hn::Store(ProductOf(axis, spread.squares, axis), d, s.mean_square_height + i);
  hn::Store(hn::Min(hn::Div(least, middle), one), d, s.variance_ratio + i);
  hn::Store(hn::Div(middle, widest), d, s.breadth + i);

  const double others = static_cast<double>(count) / static_cast<double>(count - 1);
  const DoubleVec squared_mean = hn::Mul(Dot(spread.mean, spread.mean), hn::Set(d, others * others));
  const DoubleVec squares =
      hn::Mul(hn::Add(hn::Add(spread.squares.xx, spread.squares.yy), spread.squares.zz), hn::Set(d, others));
  const DoubleMask secluded = hn::Gt(squared_mean, hn::Mul(hn::Set(d, kMaxSeclusion), hn::Sub(squares, squared_mean)));
  const DoubleMask wide = hn::Gt(middle, hn::Mul(hn::Set(d, kMinLineSpread), widest));
  uint8_t is_secluded[8] = {}, is_wide[8] = {};
  hn::StoreMaskBits(d, secluded, is_secluded);
  hn::StoreMaskBits(d, wide, is_wide);
  const bool has_enough = degree == 0 || count >= static_cast<size_t>(JetSize(degree));
  for (size_t lane = 0; lane < hn::Lanes(d) && i + lane < s.points.size; ++lane) {
    PointStatus& status = s.points.status[i + lane];
    s.is_rim[i + lane] = false;
    if (status != PointStatus::kOk) continue;
    if ((is_secluded[0] >> lane & 1) != 0) {
      status = PointStatus::kTooFewNeighbors;
    } else if ((is_wide[0] >> lane & 1) == 0 || !has_enough) {
      status = PointStatus::kSingularFit;
    }
  }
  if (degree == 0 || !has_enough) return;
  SumLanes(degree, u, v, axis, unit, count, i, s.lanes, s.system);
  hn::Store(hn::Set(d, static_cast<double>(count)), d, s.system.moments[0] + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_NORMALS_FITS_LANE_FITS_INL_H_
