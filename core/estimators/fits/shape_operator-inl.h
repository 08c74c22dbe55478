// Principal curvatures and directions from shape operators, for a vector of points at once.

#if defined(CURVD_CORE_ESTIMATORS_FITS_SHAPE_OPERATOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_SHAPE_OPERATOR_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_SHAPE_OPERATOR_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_SHAPE_OPERATOR_INL_H_
#endif

#include <algorithm>
#include <utility>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/group_shapes.h"
#include "core/estimators/principal-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The symmetric matrix of the shape operator in an orthonormal tangent basis (y, z), positive where the surface bends
// away from y x z.
struct ShapeOperator {
  DoubleTriple y, z;
  DoubleVec yy, yz, zz;
};

// Sets the basis of the plane normal to n, of unit length: y x z = n (Duff et al., "Building an orthonormal basis,
// revisited", 2017).
HWY_INLINE void SetTangents(const DoubleTriple& n, ShapeOperator& out) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0);
  const DoubleVec sign = hn::CopySign(one, n.z);
  const DoubleVec u = hn::Div(hn::Set(d, -1.0), hn::Add(sign, n.z)), v = hn::Mul(hn::Mul(n.x, n.y), u);
  out.y = {hn::MulAdd(hn::Mul(sign, u), hn::Mul(n.x, n.x), one), hn::Mul(sign, v), hn::Neg(hn::Mul(sign, n.x))};
  out.z = {v, hn::MulAdd(u, hn::Mul(n.y, n.y), sign), hn::Neg(n.y)};
}

HWY_INLINE void StoreTriple(const DoubleTriple& v, size_t i, GroupDoubleVectors& out) {
  const DoubleTag d;
  hn::Store(v.x, d, out.x + i);
  hn::Store(v.y, d, out.y + i);
  hn::Store(v.z, d, out.z + i);
}
HWY_INLINE DoubleTriple LoadTriple(const GroupDoubleVectors& vectors, size_t i) {
  const DoubleTag d;
  return {hn::Load(d, vectors.x + i), hn::Load(d, vectors.y + i), hn::Load(d, vectors.z + i)};
}

// Stores what the operators of points i, i + 1, ... say: d1 x d2 points along y x z.
HWY_INLINE void StoreShapes(const ShapeOperator& s, size_t i, GroupShapes& out) {
  const DoubleTag d;
  const DoubleVec zero = hn::Zero(d), half = hn::Set(d, 0.5);
  const DoubleVec a = hn::Mul(hn::Sub(s.yy, s.zz), half);
  const DoubleVec r = hn::Sqrt(hn::MulAdd(a, a, hn::Mul(s.yz, s.yz)));
  hn::Store(hn::Mul(hn::Add(s.yy, s.zz), half), d, out.mean + i);
  hn::Store(hn::NegMulAdd(s.yz, s.yz, hn::Mul(s.yy, s.zz)), d, out.gaussian + i);
  hn::Store(r, d, out.half_difference + i);
  // The eigenvector of the larger eigenvalue is (a + r, yz) or (yz, r - a): the longer of the two loses no digits. At
  // an umbilic any direction will do, and it is y.
  const DoubleMask first = hn::Ge(a, zero);
  DoubleVec cosine = hn::IfThenElse(first, hn::Add(a, r), s.yz);
  DoubleVec sine = hn::IfThenElse(first, s.yz, hn::Sub(r, a));
  const DoubleVec length = hn::Sqrt(hn::MulAdd(cosine, cosine, hn::Mul(sine, sine)));
  const DoubleMask any = hn::Gt(length, zero);
  cosine = hn::IfThenElse(any, hn::Div(cosine, length), hn::Set(d, 1.0));
  sine = hn::IfThenElseZero(any, hn::Div(sine, length));
  StoreTriple(AddScaled(Scale(s.y, cosine), sine, s.z), i, out.d2);
  StoreTriple(AddScaled(Scale(s.y, sine), hn::Neg(cosine), s.z), i, out.d1);
}

// Takes curvature from the shape operators of the first `size` points of a group.
HWY_INLINE void TakeShapes(const GroupShapes& shapes, size_t size, GroupCurvature& out) {
  const auto round = [&](const double* from, float* to) {
    std::transform(from, from + size, to, [](double v) { return static_cast<float>(v); });
  };
  round(shapes.mean, out.mean);
  round(shapes.gaussian, out.gaussian);
  round(shapes.half_difference, out.half_difference);
  for (const auto& [from, to] : {std::pair(&shapes.d1, &out.d1), std::pair(&shapes.d2, &out.d2)}) {
    round(from->x, to->x);
    round(from->y, to->y);
    round(from->z, to->z);
  }
}

// Writes the results of a group whose shape operators are set.
HWY_INLINE void WriteShapes(const NeighborhoodPlan& plan, const GroupShapes& shapes, GroupScratch& s,
                            PointCurvature* results) {
  GroupCurvature curvature;
  TakeShapes(shapes, s.points.size, curvature);
  ScaleCurvature(plan, s.frames.rho, s.points.size, curvature);
  WriteGroup(plan, curvature, s, results);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_SHAPE_OPERATOR_INL_H_
