// Linear regression of the normals over space (docs/numerics.md): the neighbors' normals are fitted by n = b + A q,
// with q the offset from the point in all three coordinates, by least squares. On spheres, cylinders and planes that is
// exact however far the neighborhood reaches around them. The derivative A over the tangent plane, divided by the root
// mean square length of the fitted normals, is the shape operator.
//
// With means p = E[q] and m = E[n], C = E[q q'] - p p' and D = E[n q'] - m p':
//   A = D (C + e n0 n0')^-1,   b = m - A p
// Along the point's own normal n0 a flat neighborhood has no extent, and noise would decide what A is there. So e, the
// ridge, is what makes A along n0 as large as in the tangent plane, if the normals' noise says no more of it.

#if defined(CURVD_CORE_ESTIMATORS_FITS_LINEAR_REGRESSION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_LINEAR_REGRESSION_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_LINEAR_REGRESSION_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_LINEAR_REGRESSION_INL_H_
#endif

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/linear_systems.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/frames-inl.h"
#include "core/estimators/neighbors/neighbors.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Where neighbors spread less than the root of this in one tangent direction, compared with the other, they may lie on
// a line.
inline constexpr double kNarrowLinearSpread = 0.05;

// What a vector of neighbors has: offsets in units of rho, and normals, all Odd. Zeros follow the last neighbor.
class LinearNeighbors {
 public:
  LinearNeighbors(const NeighborArrays& neighbors, float rho)
      : neighbors_(neighbors), unit_(hn::Set(DoubleTag(), 1.0 / rho)) {}

  HWY_INLINE DoubleTriple Offset(size_t j) const {
    const auto& n = neighbors_;
    return AllOdd(Scale({Widen(n.dx.data() + j), Widen(n.dy.data() + j), Widen(n.dz.data() + j)}, unit_));
  }
  HWY_INLINE DoubleTriple Normal(size_t j) const {
    const auto& n = neighbors_;
    return AllOdd({Widen(n.nx.data() + j), Widen(n.ny.data() + j), Widen(n.nz.data() + j)});
  }
  size_t count() const { return neighbors_.count; }

 private:
  static HWY_INLINE DoubleTriple AllOdd(const DoubleTriple& v) { return {Odd(v.x), Odd(v.y), Odd(v.z)}; }

  const NeighborArrays& neighbors_;
  const DoubleVec unit_;
};

// As many sums as 16 registers hold in each of two passes.
HWY_NOINLINE inline void SumOffsets(const LinearNeighbors& neighbors, DoubleVec anchor, double* out) {
  DoubleVec x = anchor, y = x, z = x, xx = x, xy = x, xz = x, yy = x, yz = x, zz = x;
  for (size_t j = 0; j < neighbors.count(); j += hn::Lanes(DoubleTag())) {
    const DoubleTriple q = neighbors.Offset(j);
    x = hn::Add(x, q.x), y = hn::Add(y, q.y), z = hn::Add(z, q.z);
    xx = AddProduct(q.x, q.x, xx, anchor), xy = AddProduct(q.x, q.y, xy, anchor);
    xz = AddProduct(q.x, q.z, xz, anchor), yy = AddProduct(q.y, q.y, yy, anchor);
    yz = AddProduct(q.y, q.z, yz, anchor), zz = AddProduct(q.z, q.z, zz, anchor);
  }
  StoreAnchoredSums(x, y, z, xx, anchor, out);
  StoreAnchoredSums(xy, xz, yy, yz, anchor, out + 4);
  StoreAnchoredSums(zz, zz, zz, zz, anchor, out + 8);
}

HWY_NOINLINE inline void SumNormalsByOffsets(const LinearNeighbors& neighbors, DoubleVec anchor, double* out) {
  DoubleVec x = anchor, y = x, z = x;  // normals
  DoubleVec xx = x, xy = x, xz = x, yx = x, yy = x, yz = x, zx = x, zy = x, zz = x;
  for (size_t j = 0; j < neighbors.count(); j += hn::Lanes(DoubleTag())) {
    const DoubleTriple q = neighbors.Offset(j), n = neighbors.Normal(j);
    x = hn::Add(x, n.x), y = hn::Add(y, n.y), z = hn::Add(z, n.z);
    xx = AddProduct(n.x, q.x, xx, anchor), xy = AddProduct(n.x, q.y, xy, anchor), xz = AddProduct(n.x, q.z, xz, anchor);
    yx = AddProduct(n.y, q.x, yx, anchor), yy = AddProduct(n.y, q.y, yy, anchor), yz = AddProduct(n.y, q.z, yz, anchor);
    zx = AddProduct(n.z, q.x, zx, anchor), zy = AddProduct(n.z, q.y, zy, anchor), zz = AddProduct(n.z, q.z, zz, anchor);
  }
  StoreAnchoredSums(x, y, z, xx, anchor, out);
  StoreAnchoredSums(xy, xz, yx, yy, anchor, out + 4);
  StoreAnchoredSums(yz, zx, zy, zz, anchor, out + 8);
}

// Sets up the problem of point i from its neighbors.
HWY_NOINLINE inline void SumLinear(const NeighborArrays& n, float rho, size_t i, LinearSystems& systems) {
  const LinearNeighbors neighbors(n, rho);
  const DoubleVec anchor = hn::Set(DoubleTag(), AnchorOf(n.count));
  double sums[12], *next = sums;
  systems.count[i] = static_cast<double>(n.count);
  SumOffsets(neighbors, anchor, sums);
  for (auto& sum : systems.offset) sum[i] = *next++;
  for (auto& sum : systems.offsets) sum[i] = *next++;
  SumNormalsByOffsets(neighbors, anchor, next = sums);
  for (auto& sum : systems.normal) sum[i] = *next++;
  for (auto& of_component : systems.normals) {
    for (auto& sum : of_component) sum[i] = *next++;
  }
}

// A symmetric matrix of each point: xx xy xz yy yz zz.
struct SymmetricVecs {
  DoubleVec xx, xy, xz, yy, yz, zz;

  HWY_INLINE DoubleTriple Times(const DoubleTriple& v) const {
    return {Dot({xx, xy, xz}, v), Dot({xy, yy, yz}, v), Dot({xz, yz, zz}, v)};
  }
  HWY_INLINE DoubleVec Trace() const { return hn::Add(xx, hn::Add(yy, zz)); }
  // Plus s v v'.
  HWY_INLINE SymmetricVecs Plus(DoubleVec s, const DoubleTriple& v) const {
    const DoubleTriple sv = Scale(v, s);
    return {hn::MulAdd(sv.x, v.x, xx), hn::MulAdd(sv.x, v.y, xy), hn::MulAdd(sv.x, v.z, xz),
            hn::MulAdd(sv.y, v.y, yy), hn::MulAdd(sv.y, v.z, yz), hn::MulAdd(sv.z, v.z, zz)};
  }
  HWY_INLINE SymmetricVecs Inverse() const {
    const SymmetricVecs c = {hn::MulSub(yy, zz, hn::Mul(yz, yz)), hn::MulSub(yz, xz, hn::Mul(xy, zz)),
                             hn::MulSub(xy, yz, hn::Mul(yy, xz)), hn::MulSub(xx, zz, hn::Mul(xz, xz)),
                             hn::MulSub(xy, xz, hn::Mul(xx, yz)), hn::MulSub(xx, yy, hn::Mul(xy, xy))};
    const DoubleVec determinant = hn::MulAdd(xz, c.xz, hn::MulAdd(xy, c.xy, hn::Mul(xx, c.xx)));
    const DoubleVec s = hn::Div(hn::Set(DoubleTag(), 1.0), determinant);
    return {hn::Mul(c.xx, s), hn::Mul(c.xy, s), hn::Mul(c.xz, s), hn::Mul(c.yy, s), hn::Mul(c.yz, s), hn::Mul(c.zz, s)};
  }
};

// Rows of any matrix.
struct RowVecs {
  DoubleTriple x, y, z;

  HWY_INLINE DoubleTriple Times(const DoubleTriple& v) const { return {Dot(x, v), Dot(y, v), Dot(z, v)}; }
  HWY_INLINE RowVecs Times(const SymmetricVecs& m) const { return {m.Times(x), m.Times(y), m.Times(z)}; }
  // The sum of the products of entries.
  HWY_INLINE DoubleVec EntriesTimes(const RowVecs& other) const {
    return hn::Add(Dot(x, other.x), hn::Add(Dot(y, other.y), Dot(z, other.z)));
  }
};

// What the regressions of points i, i + 1, ... are made of.
struct LinearMoments {
  DoubleVec count;
  DoubleTriple p, m;
  SymmetricVecs c;
  RowVecs d;
};

HWY_INLINE LinearMoments LoadLinearMoments(const LinearSystems& systems, size_t i) {
  const DoubleTag d;
  LinearMoments out;
  out.count = hn::Load(d, systems.count + i);
  const DoubleVec per_count = hn::Div(hn::Set(d, 1.0), out.count);
  const auto mean = [&](const GroupDoubles& sums) HWY_ATTR { return hn::Mul(hn::Load(d, sums + i), per_count); };
  const auto& p = out.p = {mean(systems.offset[0]), mean(systems.offset[1]), mean(systems.offset[2])};
  const auto& m = out.m = {mean(systems.normal[0]), mean(systems.normal[1]), mean(systems.normal[2])};
  const auto square = [&](int place, DoubleVec a, DoubleVec b)
                          HWY_ATTR { return hn::NegMulAdd(a, b, mean(systems.offsets[place])); };
  out.c = {square(0, p.x, p.x), square(1, p.x, p.y), square(2, p.x, p.z),
           square(3, p.y, p.y), square(4, p.y, p.z), square(5, p.z, p.z)};
  const DoubleVec least = hn::Mul(out.c.Trace(), hn::Set(d, kLeastLinearVariance));
  for (DoubleVec* const variance : {&out.c.xx, &out.c.yy, &out.c.zz}) *variance = hn::Add(*variance, least);
  const auto row = [&](int component, DoubleVec of_normal) HWY_ATTR {
    const auto& sums = systems.normals[component];
    return DoubleTriple{hn::NegMulAdd(of_normal, p.x, mean(sums[0])), hn::NegMulAdd(of_normal, p.y, mean(sums[1])),
                        hn::NegMulAdd(of_normal, p.z, mean(sums[2]))};
  };
  out.d = {row(0, m.x), row(1, m.y), row(2, m.z)};
  return out;
}

// The ridge along the unit normal `own`.
HWY_INLINE DoubleVec RidgeOf(const LinearMoments& f, const DoubleTriple& own) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), half = hn::Set(d, 0.5), trace = f.c.Trace();
  // The variance that the normals keep along each of two tangents, without a ridge.
  const DoubleVec explained = hn::Add(Dot(f.m, f.m), f.d.Times(f.c.Inverse()).EntriesTimes(f.d));
  const DoubleVec left = hn::Mul(half, hn::Max(hn::Sub(one, explained), hn::Zero(d)));
  const DoubleVec freedom = hn::Sub(f.count, hn::Set(d, kLinearSize));
  // The mean square of A's entries in the tangent plane, about: D over the plane, divided by the variance there.
  ShapeOperator plane;
  SetTangents(own, plane);
  const DoubleTriple dy = f.d.Times(plane.y), dz = f.d.Times(plane.z);
  const DoubleTriple in_y{Dot(plane.y, dy), Dot(plane.y, dz), hn::Zero(d)};
  const DoubleTriple in_z{Dot(plane.z, dy), Dot(plane.z, dz), hn::Zero(d)};
  const DoubleVec variance = hn::Mul(half, hn::Sub(trace, Dot(own, f.c.Times(own))));
  const DoubleVec squared_bend =
      hn::Div(hn::Mul(half, hn::Add(Dot(in_y, in_y), Dot(in_z, in_z))), hn::Mul(variance, variance));
  const DoubleVec ridge = hn::Div(left, hn::Mul(freedom, squared_bend));
  const DoubleMask is_told = hn::Ge(freedom, hn::Set(d, kLeastLinearFreedom));
  // A plane without any bend has none to compare with: not a number, or too large.
  return hn::IfThenElse(hn::And(is_told, hn::Lt(ridge, trace)), ridge, trace);
}

// Solves the problems of points i, i + 1, ... and stores the shape operators of the fitted fields.
HWY_INLINE void SolveLinearAt(size_t i, const LinearSystems& systems, const GroupVectors& normal, GroupShapes& shapes,
                              LinearChecks& checks) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
  const DoubleTriple own{Widen(normal.x + i), Widen(normal.y + i), Widen(normal.z + i)};
  const LinearMoments f = LoadLinearMoments(systems, i);
  const RowVecs a = f.d.Times(f.c.Plus(RidgeOf(f, own), own).Inverse());
  // Noise shortens the mean of normals, and so do the fitted ones: their root mean square tells by how much.
  const DoubleVec length = hn::Sqrt(hn::Add(Dot(f.m, f.m), a.EntriesTimes(f.d)));
  const DoubleTriple at_point = AddScaled(f.m, hn::Set(d, -1.0), a.Times(f.p));
  const DoubleVec length_at_point = hn::Sqrt(Dot(at_point, at_point));
  const DoubleTriple n = Scale(at_point, hn::Div(one, length_at_point));
  const DoubleVec per_length = hn::Div(one, length);
  ShapeOperator s;
  SetTangents(n, s);
  const DoubleTriple by_y = Scale(a.Times(s.y), per_length), by_z = Scale(a.Times(s.z), per_length);
  s.yy = Dot(by_y, s.y);
  s.yz = hn::Mul(half, hn::Add(Dot(by_y, s.z), Dot(by_z, s.y)));
  s.zz = Dot(by_z, s.z);
  StoreShapes(s, i, shapes);

  const DoubleTriple cy = f.c.Times(s.y), cz = f.c.Times(s.z);
  const DoubleVec yy = Dot(cy, s.y), yz = Dot(cy, s.z), zz = Dot(cz, s.z), trace = hn::Add(yy, zz);
  // Where all of the extent is along the normal, what was added for planes is not one across it.
  const DoubleMask has_extent = hn::Gt(trace, hn::Mul(hn::Set(d, kMinLinearSpread), f.c.Trace()));
  const DoubleVec spread = hn::Div(hn::NegMulAdd(yz, yz, hn::Mul(yy, zz)), hn::Mul(trace, trace));
  hn::Store(hn::IfThenElseZero(has_extent, spread), d, checks.spread + i);
  hn::Store(hn::Min(length, length_at_point), d, checks.length + i);
  hn::Store(Dot(n, own), d, checks.outward + i);
}

// Solves the problems of all points of the group, and stores their shapes and checks.
HWY_NOINLINE inline void SolveLinear(const LinearSystems& systems, GroupPoints& points, GroupShapes& shapes,
                                     LinearChecks& checks) {
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) {
    SolveLinearAt(i, systems, points.normal, shapes, checks);
  }
  for (size_t i = 0; i < points.size; ++i) {
    if (points.status[i] != PointStatus::kOk) continue;
    if (!(checks.length[i] >= kMinMeanNormal && checks.outward[i] > 0.0)) {
      points.status[i] = PointStatus::kInconsistentNormals;
    } else if (!(checks.spread[i] > kMinLinearSpread)) {
      points.status[i] = PointStatus::kSingularFit;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_LINEAR_REGRESSION_INL_H_
