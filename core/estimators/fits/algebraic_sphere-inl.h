// The algebraic shape operator (Lejemble, Coeurjolly, Barthe, Mellado, "Stable and efficient differential estimators on
// oriented point clouds", 2021): the sphere f(y) = c + l (y - x) + s |y - x|^2 whose gradient fits the neighbors'
// normals best, with weights w that fall to 0 at distance rho from x, and the derivative of the unit gradient of the
// field x -> f(x) that all spheres define together. Nothing is projected; x is the query point.
//
// In units of rho, with q the offset of a neighbor, n its normal, E[g] = sum w g / sum w and means p = E[q], m = E[n]:
//   s = (E[q n] - p m) / (2 B),  B = E[q q] - p p
//   l = m - 2 s p
//   c = -(p m + s C),            C = E[q q] - 2 p p
// Weights depend on x; a derivative by x goes through them. With t = 1 - |q|^2 and w = t^2:
//   grad w = 4 t q,   Hess w = 8 q q' - 4 t I

#if defined(CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/fit_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Neighbors nearer than this to distance rho, in squared distance, count as at it: their weight is 0 and has no
// derivative. (The second one jumps there, so rounding would decide.)
inline constexpr double kRim = 1e-6;

// The columns of one neighborhood.
struct SphereColumns {
  const double* moment[SphereSums::kMoments];  // 1, q, n, q n, q q
  double* q[3];
  double* n[3];
  double *one, *qn, *qq;
  double* w;
  double* t;
  double* tq[3];

  SphereColumns(size_t size, FitColumns& fits) {
    fits.Reserve(kSphereColumns, size);
    size_t next = 0;
    one = fits.column(next++);
    for (double*& column : q) column = fits.column(next++);
    for (double*& column : n) column = fits.column(next++);
    qn = fits.column(next++);
    qq = fits.column(next++);
    for (int m = 0; m < SphereSums::kMoments; ++m) moment[m] = fits.column(static_cast<size_t>(m));
    w = fits.column(next++);
    t = fits.column(next++);
    for (double*& column : tq) column = fits.column(next++);
  }
};

HWY_INLINE void FillSphereColumns(const NeighborArrays& neighbors, double unit, const SphereColumns& columns) {
  const DoubleTag d;
  const DoubleVec scale = hn::Set(d, unit), one = hn::Set(d, 1.0);
  for (size_t j = 0; j < neighbors.count; j += hn::Lanes(d)) {
    const DoubleTriple q{hn::Mul(Widen(neighbors.dx.data() + j), scale), hn::Mul(Widen(neighbors.dy.data() + j), scale),
                         hn::Mul(Widen(neighbors.dz.data() + j), scale)};
    const DoubleTriple n{Widen(neighbors.nx.data() + j), Widen(neighbors.ny.data() + j),
                         Widen(neighbors.nz.data() + j)};
    const DoubleVec qq = Dot(q, q);
    const DoubleMask used = hn::FirstN(d, neighbors.count - j);
    const DoubleVec inner = hn::Sub(one, qq);
    const DoubleVec t = hn::IfThenElseZero(hn::And(used, hn::Gt(inner, hn::Set(d, kRim))), inner);
    hn::Store(one, d, columns.one + j);
    hn::Store(q.x, d, columns.q[0] + j);
    hn::Store(q.y, d, columns.q[1] + j);
    hn::Store(q.z, d, columns.q[2] + j);
    hn::Store(n.x, d, columns.n[0] + j);
    hn::Store(n.y, d, columns.n[1] + j);
    hn::Store(n.z, d, columns.n[2] + j);
    hn::Store(Dot(q, n), d, columns.qn + j);
    hn::Store(Odd(qq), d, columns.qq + j);
    hn::Store(OddProduct(t, t), d, columns.w + j);
    hn::Store(t, d, columns.t + j);
    hn::Store(OddProduct(t, q.x), d, columns.tq[0] + j);
    hn::Store(OddProduct(t, q.y), d, columns.tq[1] + j);
    hn::Store(OddProduct(t, q.z), d, columns.tq[2] + j);
  }
}

// Sums the weights and their gradients times each moment for point i.
HWY_INLINE void SumMoments(const SphereColumns& columns, size_t count, size_t i, SphereSums& out) {
  constexpr double kGradient = 4.0;
  double sums[4];
  for (int first : {0, 4}) {
    const FourColumns four{
        {columns.moment[first], columns.moment[first + 1], columns.moment[first + 2], columns.moment[first + 3]}};
    DotFour(columns.w, four, count, sums);
    for (int k = 0; k < 4; ++k) out.weighted[first + k][i] = sums[k];
    for (int a = 0; a < 3; ++a) {
      DotFour(columns.tq[a], four, count, sums);
      for (int k = 0; k < 4; ++k) out.gradient[a][first + k][i] = kGradient * sums[k];
    }
  }
  constexpr int kLast = SphereSums::kMoments - 1;
  DotFour(columns.qq, {{columns.w, columns.tq[0], columns.tq[1], columns.tq[2]}}, count, sums);
  out.weighted[kLast][i] = sums[0];
  for (int a = 0; a < 3; ++a) out.gradient[a][kLast][i] = kGradient * sums[1 + a];
}

// The sphere, and how c depends on the weights: d c / d w of a neighbor is `constant` + q `by_q` + n `by_n` + q n
// `by_qn`
// + q q `by_qq`, divided by `weight`.
struct Sphere {
  DoubleVec weight;  // sum of w
  DoubleTriple p, m;
  DoubleVec variance;  // B
  DoubleVec s;
  DoubleVec ratio;  // C / B
  DoubleVec constant, by_qn, by_qq;
  DoubleTriple by_q, by_n;
};

HWY_INLINE Sphere FitSphere(const DoubleVec* weighted) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), two = hn::Set(d, 2.0), half = hn::Set(d, 0.5);
  Sphere f;
  f.weight = weighted[0];
  const DoubleVec per_weight = hn::Div(one, f.weight);
  f.p = Scale({weighted[1], weighted[2], weighted[3]}, per_weight);
  f.m = Scale({weighted[4], weighted[5], weighted[6]}, per_weight);
  const DoubleVec qn = hn::Mul(weighted[7], per_weight), qq = hn::Mul(weighted[8], per_weight);
  const DoubleVec pp = Dot(f.p, f.p);
  f.variance = hn::Sub(qq, pp);
  const DoubleVec per_variance = hn::Div(one, f.variance);
  f.s = hn::Mul(hn::Mul(half, hn::Sub(qn, Dot(f.p, f.m))), per_variance);
  f.ratio = hn::Mul(hn::NegMulAdd(two, pp, qq), per_variance);
  const DoubleVec mixed = hn::NegMulAdd(half, f.ratio, one);  // 1 - C / 2B
  const DoubleVec by_pp = hn::Mul(f.s, hn::MulSub(two, f.ratio, hn::Set(d, 4.0)));
  f.by_q = Scale(AddScaled(Scale(f.m, mixed), by_pp, f.p), hn::Set(d, -1.0));
  f.by_n = Scale(f.p, hn::Neg(mixed));
  f.by_qn = hn::Neg(hn::Mul(half, f.ratio));
  f.by_qq = hn::Mul(f.s, hn::Sub(f.ratio, one));
  // The weighted mean of d c / d w is 0: c does not change when all weights grow in proportion.
  f.constant =
      hn::Neg(hn::Add(hn::Add(Dot(f.by_q, f.p), Dot(f.by_n, f.m)), hn::MulAdd(f.by_qn, qn, hn::Mul(f.by_qq, qq))));
  return f;
}

// Sums d c / d w times the Hessian of w for point i.
HWY_INLINE void SumInfluence(const SphereColumns& columns, const Sphere& f, size_t count, size_t i, SphereSums& out) {
  const DoubleTag d;
  // What an influence is at most.
  const auto size = [](DoubleVec v) HWY_ATTR { return std::abs(hn::GetLane(v)); };
  const double most = size(f.constant) + size(f.by_qn) + size(f.by_qq) + size(f.by_q.x) + size(f.by_q.y) +
                      size(f.by_q.z) + size(f.by_n.x) + size(f.by_n.y) + size(f.by_n.z);
  // In units of a power of two above that; where it is no number, so is the result.
  int exponent = 0;
  if (std::isfinite(most)) std::frexp(most, &exponent);
  const double unit = std::ldexp(1.0, std::clamp(exponent, -1000, 1000));
  const DoubleVec per_unit = hn::Set(d, 1.0 / unit), anchor = hn::Set(d, AnchorOf(count));
  DoubleVec xx = anchor, xy = xx, xz = xx, yy = xx, yz = xx, zz = xx, trace = xx;
  for (size_t j = 0; j < count; j += hn::Lanes(d)) {
    const DoubleTriple q{hn::Load(d, columns.q[0] + j), hn::Load(d, columns.q[1] + j), hn::Load(d, columns.q[2] + j)};
    const DoubleTriple n{hn::Load(d, columns.n[0] + j), hn::Load(d, columns.n[1] + j), hn::Load(d, columns.n[2] + j)};
    const DoubleVec by_products =
        hn::MulAdd(f.by_qn, hn::Load(d, columns.qn + j), hn::MulAdd(f.by_qq, hn::Load(d, columns.qq + j), f.constant));
    const DoubleVec t = hn::Load(d, columns.t + j);
    const DoubleVec influence =
        hn::IfThenElseZero(hn::Gt(t, hn::Zero(d)), hn::Add(hn::Add(Dot(f.by_q, q), Dot(f.by_n, n)), by_products));
    const DoubleVec relative = OddProduct(influence, per_unit);
    const DoubleTriple along{OddProduct(relative, q.x), OddProduct(relative, q.y), OddProduct(relative, q.z)};
    xx = AddProduct(along.x, q.x, xx, anchor), xy = AddProduct(along.x, q.y, xy, anchor);
    xz = AddProduct(along.x, q.z, xz, anchor), yy = AddProduct(along.y, q.y, yy, anchor);
    yz = AddProduct(along.y, q.z, yz, anchor), zz = AddProduct(along.z, q.z, zz, anchor);
    trace = AddProduct(relative, t, trace, anchor);
  }
  double sums[8];
  StoreAnchoredSums(xx, xy, xz, trace, anchor, sums);
  StoreAnchoredSums(yy, yz, zz, trace, anchor, sums + 4);
  const double scale = 8.0 * unit / hn::GetLane(f.weight), identity = -4.0 * unit / hn::GetLane(f.weight) * sums[3];
  out.influence_hessian[0][i] = scale * sums[0] + identity;
  out.influence_hessian[1][i] = scale * sums[1];
  out.influence_hessian[2][i] = scale * sums[2];
  out.influence_hessian[3][i] = scale * sums[4] + identity;
  out.influence_hessian[4][i] = scale * sums[5];
  out.influence_hessian[5][i] = scale * sums[6] + identity;
}

// Sums what the sphere of point i and its derivatives need over its neighbors.
HWY_NOINLINE inline void SumSphere(const NeighborArrays& neighbors, float rho, size_t i, FitColumns& column_room,
                                   SphereSums& sums) {
  const DoubleTag d;
  const size_t count = neighbors.count;
  const SphereColumns columns(count, column_room);
  FillSphereColumns(neighbors, 1.0 / rho, columns);
  SumMoments(columns, count, i, sums);
  DoubleVec weighted[SphereSums::kMoments];
  for (int m = 0; m < SphereSums::kMoments; ++m) weighted[m] = hn::Set(d, sums.weighted[m][i]);
  SumInfluence(columns, FitSphere(weighted), count, i, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_
