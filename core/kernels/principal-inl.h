// From measures to curvature: densities, and the principal curvatures and directions of the tangent tensor.

#if defined(CURVD_CORE_KERNELS_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_KERNELS_PRINCIPAL_INL_H_
#undef CURVD_CORE_KERNELS_PRINCIPAL_INL_H_
#else
#define CURVD_CORE_KERNELS_PRINCIPAL_INL_H_
#endif

#include <cmath>
#include <cstring>

#include "core/group_buffers.h"
#include "core/kernels/measures-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Curvature of each point of a group, in units of 1 / rho.
struct GroupCurvature {
  alignas(64) GroupScalars mean, gaussian, half_difference;
  GroupVectors d1, d2;
};

// The eigenvector of the larger eigenvalue of [[a, b], [b, -a]] is (a + r, b) or (b, r - a), r = |(a, b)|: the longer
// of the two loses no digits. For a = b = 0 any direction will do, and it is u.
HWY_INLINE void PrincipalDirections(const Frame& frame, FloatVec a, FloatVec b, FloatVec r, size_t i,
                                    GroupCurvature& out) {
  const FloatTag d;
  const FloatMask first = hn::Ge(a, hn::Zero(d));
  FloatVec x = hn::IfThenElse(first, hn::Add(a, r), b);
  FloatVec y = hn::IfThenElse(first, b, hn::Sub(r, a));
  const FloatVec length = hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y)));
  const FloatMask any = hn::Gt(length, hn::Zero(d));
  x = hn::IfThenElse(any, hn::Div(x, length), hn::Set(d, 1.0f));
  y = hn::IfThenElseZero(any, hn::Div(y, length));
  const Triple d2 = Add(Scale(frame.u, x), Scale(frame.v, y));
  // d1 is d2 turned back by a right angle, so that d1 x d2 points along the normal.
  const Triple d1 = Sub(Scale(frame.u, y), Scale(frame.v, x));
  hn::Store(d1.x, d, out.d1.x + i);
  hn::Store(d1.y, d, out.d1.y + i);
  hn::Store(d1.z, d, out.d1.z + i);
  hn::Store(d2.x, d, out.d2.x + i);
  hn::Store(d2.y, d, out.d2.y + i);
  hn::Store(d2.z, d, out.d2.z + i);
}

HWY_INLINE void ComputeCurvature(const GroupScratch::Buffers& b, GroupCurvature& out) {
  const FloatTag d;
  const FloatVec half = hn::Set(d, 0.5f);
  for (size_t i = 0; i < b.size; i += hn::Lanes(d)) {
    const GroupMeasures& m = b.measures;
    const FloatVec per_area = hn::Div(hn::Set(d, 1.0f), hn::Load(d, m.area + i));
    const FloatVec uu = hn::Mul(hn::Load(d, m.tensor_uu + i), per_area);
    const FloatVec uv = hn::Mul(hn::Load(d, m.tensor_uv + i), per_area);
    const FloatVec vv = hn::Mul(hn::Load(d, m.tensor_vv + i), per_area);
    const FloatVec a = hn::Mul(hn::Sub(uu, vv), half);
    const FloatVec r = hn::Sqrt(hn::MulAdd(a, a, hn::Mul(uv, uv)));
    const FloatVec mean = hn::Mul(hn::Load(d, m.mean + i), per_area);
    const FloatVec gaussian = hn::Mul(hn::Load(d, m.gaussian + i), per_area);
    hn::Store(mean, d, out.mean + i);
    hn::Store(gaussian, d, out.gaussian + i);
    hn::Store(r, d, out.half_difference + i);
    PrincipalDirections({LoadTriple(b.u, i), LoadTriple(b.v, i)}, a, uv, r, i, out);
  }
}

// Triangles whose area facing the normal is below this fraction of rho^2 are too thin to divide by: float32 offsets
// carry an area error near 1e-7 rho^2, which is then 1 % of it.
inline constexpr float kMinRelativeArea = 1e-5f;

// Writes the points of the group to the field, in the caller's unit.
HWY_INLINE void WriteGroup(const EstimationPlan& plan, const GroupScratch::Buffers& b, const GroupCurvature& c,
                           PointCurvature* field) {
  for (size_t i = 0; i < b.size; ++i) {
    PointCurvature point = UndefinedCurvature(b.status[i]);
    const double unit = plan.scale / b.rho[i];
    const double mean = c.mean[i] * unit;
    const double difference = c.half_difference[i] * unit;
    if (b.status[i] == PointStatus::kOk) {
      const auto k1 = static_cast<float>(mean - difference);
      const auto k2 = static_cast<float>(mean + difference);
      const auto gaussian = static_cast<float>(c.gaussian[i] * unit * unit);
      if (b.measures.area[i] > kMinRelativeArea && std::isfinite(k1 + k2) && std::isfinite(gaussian)) {
        point = {static_cast<float>(mean),
                 gaussian,
                 k1,
                 k2,
                 {c.d1.x[i], c.d1.y[i], c.d1.z[i]},
                 {c.d2.x[i], c.d2.y[i], c.d2.z[i]},
                 static_cast<float>(b.radius[i] / plan.scale),
                 PointStatus::kOk};
      } else {
        point.status = PointStatus::kDegenerateArea;
      }
    }
    if (plan.by_radius) point.radius = static_cast<float>(plan.radius);
    std::memcpy(&field[b.id[i]], &point, sizeof(point));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_KERNELS_PRINCIPAL_INL_H_
