// From measures to curvature: densities, and the principal curvatures and directions of the tangent tensor.

#if defined(CURVD_CORE_ESTIMATORS_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_PRINCIPAL_INL_H_
#undef CURVD_CORE_ESTIMATORS_PRINCIPAL_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_PRINCIPAL_INL_H_
#endif

#include <cmath>
#include <cstring>

#include "core/estimators/group_scratch.h"
#include "core/estimators/lines/refuse_lines-inl.h"
#include "core/estimators/measures-inl.h"
#include "core/estimators/neighborhood_plan.h"
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

// Curvature from measures, for the first `size` points of a group.
HWY_NOINLINE inline void ComputeCurvature(const GroupMeasures& m, const GroupFrames& frames, size_t size,
                                          GroupCurvature& out) {
  const FloatTag d;
  const FloatVec half = hn::Set(d, 0.5f);
  for (size_t i = 0; i < size; i += hn::Lanes(d)) {
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
    PrincipalDirections({LoadTriple(frames.u, i), LoadTriple(frames.v, i)}, a, uv, r, i, out);
  }
}

// Triangles whose area facing the normal is below this fraction of rho^2 are too thin to divide by: float32 offsets
// carry an area error near 1e-7 rho^2, which is then 1 % of it.
inline constexpr float kMinRelativeArea = 1e-5f;

HWY_INLINE void RefuseThinAreas(const GroupMeasures& measures, GroupPoints& points) {
  for (size_t i = 0; i < points.size; ++i) {
    if (points.status[i] == PointStatus::kOk && !(measures.area[i] > kMinRelativeArea)) {
      points.status[i] = PointStatus::kDegenerateArea;
    }
  }
}

// Takes lengths in units of rho to the caller's: divides curvature by rho and multiplies by the index's scale.
HWY_INLINE void ScaleCurvature(const NeighborhoodPlan& plan, const GroupScalars& rho_of, size_t size,
                               GroupCurvature& c) {
  const FloatTag d;
  // Two factors, each a float: the scale itself may not be one.
  const FloatVec scale = hn::Set(d, plan.half_scale), other_scale = hn::Set(d, plan.other_half_scale);
  for (size_t i = 0; i < size; i += hn::Lanes(d)) {
    const FloatVec rho = hn::Load(d, rho_of + i);
    const auto to_unit = [&](FloatVec v) { return hn::Mul(hn::Mul(hn::Div(v, rho), scale), other_scale); };
    hn::Store(to_unit(hn::Load(d, c.mean + i)), d, c.mean + i);
    hn::Store(to_unit(hn::Load(d, c.half_difference + i)), d, c.half_difference + i);
    hn::Store(to_unit(to_unit(hn::Load(d, c.gaussian + i))), d, c.gaussian + i);
  }
}

// Writes the points of the group, whose curvature is in the caller's unit, to their slots, and counts their status.
HWY_INLINE void WriteGroup(const NeighborhoodPlan& plan, const GroupCurvature& c, GroupScratch& scratch,
                           PointCurvature* results) {
  const GroupPoints& points = scratch.points;
  for (size_t i = 0; i < points.size; ++i) {
    const float k1 = c.mean[i] - c.half_difference[i], k2 = c.mean[i] + c.half_difference[i];
    PointStatus status = points.status[i];
    // A curvature that is no float32 comes out as infinity, and here as NaN.
    const bool finite = (k1 + k2 + c.gaussian[i]) * 0.0f == 0.0f;
    if (status == PointStatus::kOk && !finite) status = PointStatus::kDegenerateArea;
    PointCurvature point = {
        c.mean[i], c.gaussian[i],   k1, k2, {c.d1.x[i], c.d1.y[i], c.d1.z[i]}, {c.d2.x[i], c.d2.y[i], c.d2.z[i]},
        0.0f,      PointStatus::kOk};
    if (status != PointStatus::kOk) point = UndefinedCurvature(status);
    if (plan.search.by_radius) {
      point.radius = static_cast<float>(plan.radius);
    } else if (status != PointStatus::kTooFewNeighbors) {
      const float radius = std::sqrt(scratch.neighborhoods.squared_radius[i]) * plan.radius_factor;
      point.radius = radius / plan.half_scale / plan.other_half_scale;
    }
    ++scratch.status_counts[static_cast<size_t>(status)];
    std::memcpy(&results[points.slot[i]], &point, sizeof(point));
  }
}

// Triangles of less than this share of the area that they have where neighbors lie evenly may be those of a line.
inline constexpr float kNarrowArea = 0.3f;

// Writes the results of a group whose measures are set. `usual_area` is the area, in units of rho^2, that triangles
// have over neighbors that lie evenly around a point. `searching` as of RefuseLines.
HWY_INLINE void WriteMeasured(const SpatialIndex& index, const NeighborhoodPlan& plan, float usual_area,
                              GroupScratch& searching, MeasuringScratch& s, PointCurvature* results) {
  GroupCurvature curvature;
  ComputeCurvature(s.measures, s.frames, s.points.size, curvature);
  RefuseThinAreas(s.measures, s.points);
  const float narrow = kNarrowArea * usual_area;
  RefuseLines(
      index, plan, /*fades=*/false, PointStatus::kDegenerateArea, [&](size_t i) { return s.measures.area[i] < narrow; },
      searching, s);
  ScaleCurvature(plan, s.frames.rho, s.points.size, curvature);
  WriteGroup(plan, curvature, s, results);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_PRINCIPAL_INL_H_
