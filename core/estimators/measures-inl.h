// Corrected curvature measures of triangles with linearly interpolated normals, for a vector of triangles at once.
//
// For a triangle with corners x0 x1 x2, normals u0 u1 u2 and their mean w (Lachaud et al. 2023, Property 1; the mean
// curvature measure with 1/4, docs/numerics.md):
//   area      1/2 <w, e1 x e2>                          e1 = x1 - x0, e2 = x2 - x0
//   mean      1/4 <w, (u0 - u2) x e1 + (u1 - u0) x e2>
//   gaussian  1/2 <u0, (u1 - u0) x (u2 - u0)>
//   tensor    1/2 <w, <Y, u1 - u0> X x e2 - <Y, u2 - u0> X x e1>   for tangent X, Y
// All are relative to the query point, and normals enter by their differences.

#if defined(CURVD_CORE_ESTIMATORS_MEASURES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_MEASURES_INL_H_
#undef CURVD_CORE_ESTIMATORS_MEASURES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_MEASURES_INL_H_
#endif

#include "core/estimators/measures.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

inline constexpr float kSqrt3 = 1.7320508f;

// A vector of points or directions.
struct Triple {
  FloatVec x, y, z;
};

HWY_INLINE Triple LoadTriple(const GroupVectors& vectors, size_t i) {
  const FloatTag d;
  return {hn::Load(d, vectors.x + i), hn::Load(d, vectors.y + i), hn::Load(d, vectors.z + i)};
}
// The vector of point i in all lanes.
HWY_INLINE Triple Broadcast(const GroupVectors& vectors, size_t i) {
  const FloatTag d;
  return {hn::Set(d, vectors.x[i]), hn::Set(d, vectors.y[i]), hn::Set(d, vectors.z[i])};
}
HWY_INLINE Triple Add(const Triple& a, const Triple& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Triple Sub(const Triple& a, const Triple& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Triple Scale(const Triple& a, FloatVec s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE FloatVec Dot(const Triple& a, const Triple& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE Triple Cross(const Triple& a, const Triple& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}

// Tangent frame (u, v, normal), right-handed.
struct Frame {
  Triple u, v;
};

// A triangle's corner: offset from the query point, and normal relative to the query point's.
struct Corner {
  Triple offset;
  Triple normal;
};

struct Measures {
  FloatVec area, mean, gaussian, tensor_uu, tensor_uv, tensor_vv;
};

HWY_INLINE Measures ZeroMeasures() {
  const FloatVec zero = hn::Zero(FloatTag());
  return {zero, zero, zero, zero, zero, zero};
}

// Adds the measures of one triangle a lane, turned so that its area is not negative. `own` is the query's normal.
HWY_INLINE void AddTriangle(const Frame& frame, const Triple& own, const Corner* corners, Measures& sum) {
  const FloatTag d;
  const Triple e1 = Sub(corners[1].offset, corners[0].offset);
  const Triple e2 = Sub(corners[2].offset, corners[0].offset);
  const Triple n1 = Sub(corners[1].normal, corners[0].normal);
  const Triple n2 = Sub(corners[2].normal, corners[0].normal);
  const Triple third =
      Scale(Add(Add(corners[0].normal, corners[1].normal), corners[2].normal), hn::Set(d, 1.0f / 3.0f));
  const Triple w = Add(own, third);
  const FloatVec twice_area = Dot(w, Cross(e1, e2));
  const FloatVec half = hn::CopySign(hn::Set(d, 0.5f), twice_area);  // one half, with the turn of the triangle
  const FloatVec quarter = hn::Mul(half, hn::Set(d, 0.5f));
  // <w, X x e> = <X, e x w>
  const Triple e1_w = Cross(e1, w);
  const Triple e2_w = Cross(e2, w);
  const FloatVec u_e1 = Dot(frame.u, e1_w), v_e1 = Dot(frame.v, e1_w);
  const FloatVec u_e2 = Dot(frame.u, e2_w), v_e2 = Dot(frame.v, e2_w);
  const FloatVec u_n1 = Dot(frame.u, n1), v_n1 = Dot(frame.v, n1);
  const FloatVec u_n2 = Dot(frame.u, n2), v_n2 = Dot(frame.v, n2);
  const FloatVec uu = hn::NegMulAdd(u_n2, u_e1, hn::Mul(u_n1, u_e2));
  const FloatVec uv = hn::NegMulAdd(v_n2, u_e1, hn::Mul(v_n1, u_e2));
  const FloatVec vu = hn::NegMulAdd(u_n2, v_e1, hn::Mul(u_n1, v_e2));
  const FloatVec vv = hn::NegMulAdd(v_n2, v_e1, hn::Mul(v_n1, v_e2));
  sum.area = hn::MulAdd(half, twice_area, sum.area);
  sum.mean = hn::MulAdd(quarter, hn::Sub(Dot(n1, e2_w), Dot(n2, e1_w)), sum.mean);
  sum.gaussian = hn::MulAdd(half, Dot(Add(own, corners[0].normal), Cross(n1, n2)), sum.gaussian);
  sum.tensor_uu = hn::MulAdd(half, uu, sum.tensor_uu);
  sum.tensor_uv = hn::MulAdd(quarter, hn::Add(uv, vu), sum.tensor_uv);
  sum.tensor_vv = hn::MulAdd(half, vv, sum.tensor_vv);
}

// Stores a vector of measures for points i, i + 1, ... of the group.
HWY_INLINE void StoreMeasures(const Measures& m, size_t i, GroupMeasures& out) {
  const FloatTag d;
  hn::Store(m.area, d, out.area + i);
  hn::Store(m.mean, d, out.mean + i);
  hn::Store(m.gaussian, d, out.gaussian + i);
  hn::Store(m.tensor_uu, d, out.tensor_uu + i);
  hn::Store(m.tensor_uv, d, out.tensor_uv + i);
  hn::Store(m.tensor_vv, d, out.tensor_vv + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_MEASURES_INL_H_
