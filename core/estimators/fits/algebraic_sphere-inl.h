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
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/fit_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Neighbors nearer than this to distance rho, in squared distance, count as at it: their weight is 0 and has no
// derivative. (The second one jumps there, so rounding would decide.)
inline constexpr double kRim = 1e-6;

// Where neighbors are more than the columns hold, these are filled with so many at a time, which stay in the first
// cache, and what is needed again is computed again.
inline constexpr size_t kSphereBlock = 128;

// What a vector of neighbors comes to, in units of rho. What pads the last vector has no weight.
struct SphereNeighbors {
  DoubleTriple q, n;
  DoubleVec qn;  // q n
  DoubleVec qq;  // q q
  DoubleVec t;   // 1 - |q|^2, or 0 from the rim on
};

HWY_INLINE SphereNeighbors LoadSphereNeighbors(const NeighborArrays& neighbors, size_t j, DoubleVec unit) {
  const DoubleTag d;
  SphereNeighbors s;
  s.q = {hn::Mul(Widen(neighbors.dx.data() + j), unit), hn::Mul(Widen(neighbors.dy.data() + j), unit),
         hn::Mul(Widen(neighbors.dz.data() + j), unit)};
  s.n = {Widen(neighbors.nx.data() + j), Widen(neighbors.ny.data() + j), Widen(neighbors.nz.data() + j)};
  const DoubleVec qq = Dot(s.q, s.q), inner = hn::Sub(hn::Set(d, 1.0), qq);
  s.qn = Dot(s.q, s.n);
  s.qq = Odd(qq);
  const DoubleMask used = hn::FirstN(d, neighbors.count - j);
  s.t = hn::IfThenElseZero(hn::And(used, hn::Gt(inner, hn::Set(d, kRim))), inner);
  return s;
}

// The columns of a block of neighbors. w and t q are Odd, and so is q q.
struct SphereColumns {
  const double* moment[SphereSums::kMoments];  // 1, q, n, q n, q q
  double* q[3];
  double* n[3];
  double *one, *qn, *qq;
  double* w;
  double* t;  // 1 - |q|^2, or 0 from the rim on
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

// Fills the columns with neighbors [first, last).
HWY_INLINE void FillSphereColumns(const NeighborArrays& neighbors, size_t first, size_t last, DoubleVec unit,
                                  const SphereColumns& columns) {
  const DoubleTag d;
  for (size_t k = 0; first + k < last; k += hn::Lanes(d)) {
    const SphereNeighbors s = LoadSphereNeighbors(neighbors, first + k, unit);
    hn::Store(hn::Set(d, 1.0), d, columns.one + k);
    hn::Store(s.q.x, d, columns.q[0] + k);
    hn::Store(s.q.y, d, columns.q[1] + k);
    hn::Store(s.q.z, d, columns.q[2] + k);
    hn::Store(s.n.x, d, columns.n[0] + k);
    hn::Store(s.n.y, d, columns.n[1] + k);
    hn::Store(s.n.z, d, columns.n[2] + k);
    hn::Store(s.qn, d, columns.qn + k);
    hn::Store(s.qq, d, columns.qq + k);
    hn::Store(OddProduct(s.t, s.t), d, columns.w + k);
    hn::Store(s.t, d, columns.t + k);
    hn::Store(OddProduct(s.t, s.q.x), d, columns.tq[0] + k);
    hn::Store(OddProduct(s.t, s.q.y), d, columns.tq[1] + k);
    hn::Store(OddProduct(s.t, s.q.z), d, columns.tq[2] + k);
  }
}

HWY_INLINE SphereNeighbors LoadSphereNeighbors(const SphereColumns& columns, size_t j) {
  const DoubleTag d;
  const auto load = [&](const double* column) HWY_ATTR { return hn::Load(d, column + j); };
  return {{load(columns.q[0]), load(columns.q[1]), load(columns.q[2])},
          {load(columns.n[0]), load(columns.n[1]), load(columns.n[2])},
          load(columns.qn),
          load(columns.qq),
          load(columns.t)};
}

// Sums of the weight, and of its derivatives along each axis over 4, times each moment.
struct MomentSums {
  double of_factor[4][SphereSums::kMoments] = {};

  // Adds the first `count` neighbors of the columns.
  HWY_INLINE void Add(const SphereColumns& columns, size_t count, DoubleVec anchor) {
    const double* const factors[4] = {columns.w, columns.tq[0], columns.tq[1], columns.tq[2]};
    double sums[4];
    for (int first : {0, 4}) {
      const FourColumns four{
          {columns.moment[first], columns.moment[first + 1], columns.moment[first + 2], columns.moment[first + 3]}};
      for (int f = 0; f < 4; ++f) {
        DotFour(factors[f], four, count, anchor, sums);
        for (int k = 0; k < 4; ++k) of_factor[f][first + k] += sums[k];
      }
    }
    DotFour(columns.qq, {{factors[0], factors[1], factors[2], factors[3]}}, count, anchor, sums);
    for (int f = 0; f < 4; ++f) of_factor[f][SphereSums::kMoments - 1] += sums[f];
  }

  void Store(size_t i, SphereSums& out) const {
    for (int m = 0; m < SphereSums::kMoments; ++m) {
      out.weighted[m][i] = of_factor[0][m];
      for (int axis = 0; axis < 3; ++axis) out.gradient[axis][m][i] = 4.0 * of_factor[1 + axis][m];
    }
  }
};

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

// d c / d w times the Hessian of w, summed over neighbors. What is summed is in units of `scale`, a power of two above
// all influences, if these are within what has an inverse; where they are not, there is no result.
class InfluenceSums {
 public:
  InfluenceSums(const Sphere& f, DoubleVec anchor)
      : anchor_(anchor), xx_(anchor), xy_(anchor), xz_(anchor), yy_(anchor), yz_(anchor), zz_(anchor), trace_(anchor) {
    const auto size = [](DoubleVec v) HWY_ATTR { return std::abs(hn::GetLane(v)); };
    const double most = size(f.constant) + size(f.by_qn) + size(f.by_qq) + size(f.by_q.x) + size(f.by_q.y) +
                        size(f.by_q.z) + size(f.by_n.x) + size(f.by_n.y) + size(f.by_n.z);
    if (most > 0x1p-1000 && most < 0x1p1000) {
      scale_ = 2.0 * std::bit_cast<double>(std::bit_cast<uint64_t>(most) & 0xFFF0000000000000u);
    }
  }

  // Adds `count` neighbors, of which load(j) has a vector.
  template <class Load>
  HWY_INLINE void Add(const Load& load, const Sphere& f, size_t count) {
    const DoubleTag d;
    const DoubleVec per_scale = hn::Set(d, 1.0 / scale_), anchor = anchor_;
    DoubleVec xx = xx_, xy = xy_, xz = xz_, yy = yy_, yz = yz_, zz = zz_, trace = trace_;
    for (size_t j = 0; j < count; j += hn::Lanes(d)) {
      const SphereNeighbors s = load(j);
      const DoubleTriple& q = s.q;
      const DoubleVec by_products = hn::MulAdd(f.by_qn, s.qn, hn::MulAdd(f.by_qq, s.qq, f.constant));
      const DoubleVec influence =
          hn::IfThenElseZero(hn::Gt(s.t, hn::Zero(d)), hn::Add(hn::Add(Dot(f.by_q, q), Dot(f.by_n, s.n)), by_products));
      const DoubleVec relative = OddProduct(influence, per_scale);
      const DoubleTriple along{OddProduct(relative, q.x), OddProduct(relative, q.y), OddProduct(relative, q.z)};
      xx = AddProduct(along.x, q.x, xx, anchor), xy = AddProduct(along.x, q.y, xy, anchor);
      xz = AddProduct(along.x, q.z, xz, anchor), yy = AddProduct(along.y, q.y, yy, anchor);
      yz = AddProduct(along.y, q.z, yz, anchor), zz = AddProduct(along.z, q.z, zz, anchor);
      trace = AddProduct(relative, s.t, trace, anchor);
    }
    xx_ = xx, xy_ = xy, xz_ = xz, yy_ = yy, yz_ = yz, zz_ = zz, trace_ = trace;
  }

  void Store(const Sphere& f, size_t i, SphereSums& out) const {
    double sums[8];
    StoreAnchoredSums(xx_, xy_, xz_, trace_, anchor_, sums);
    StoreAnchoredSums(yy_, yz_, zz_, trace_, anchor_, sums + 4);
    const double weight = hn::GetLane(f.weight), scale = 8.0 * scale_ / weight;
    const double identity = -4.0 * scale_ / weight * sums[3];
    out.influence_hessian[0][i] = scale * sums[0] + identity;
    out.influence_hessian[1][i] = scale * sums[1];
    out.influence_hessian[2][i] = scale * sums[2];
    out.influence_hessian[3][i] = scale * sums[4] + identity;
    out.influence_hessian[4][i] = scale * sums[5];
    out.influence_hessian[5][i] = scale * sums[6] + identity;
  }

 private:
  double scale_ = 1.0;
  DoubleVec anchor_, xx_, xy_, xz_, yy_, yz_, zz_, trace_;
};

// Sums what the sphere of point i and its derivatives need over its neighbors: first the moments, then what follows
// from the sphere that they determine.
HWY_NOINLINE inline void SumSphere(const NeighborArrays& neighbors, float rho, size_t i, FitColumns& column_room,
                                   SphereSums& sums) {
  const DoubleTag d;
  const size_t block = neighbors.count <= kMostInSphereColumns ? neighbors.count : kSphereBlock;
  const SphereColumns columns(block, column_room);
  const DoubleVec unit = hn::Set(d, 1.0 / rho), anchor = hn::Set(d, AnchorOf(neighbors.count));
  MomentSums moments;
  for (size_t first = 0; first < neighbors.count; first += block) {
    const size_t count = std::min(neighbors.count - first, block);
    FillSphereColumns(neighbors, first, first + count, unit, columns);
    moments.Add(columns, count, anchor);
  }
  moments.Store(i, sums);
  DoubleVec weighted[SphereSums::kMoments];
  for (int m = 0; m < SphereSums::kMoments; ++m) weighted[m] = hn::Set(d, moments.of_factor[0][m]);
  const Sphere sphere = FitSphere(weighted);
  InfluenceSums influence(sphere, anchor);
  if (block == neighbors.count) {
    influence.Add([&](size_t j) HWY_ATTR { return LoadSphereNeighbors(columns, j); }, sphere, neighbors.count);
  } else {
    influence.Add([&](size_t j) HWY_ATTR { return LoadSphereNeighbors(neighbors, j, unit); }, sphere, neighbors.count);
  }
  influence.Store(sphere, i, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_ALGEBRAIC_SPHERE_INL_H_
