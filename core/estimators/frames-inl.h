// What estimators need of points whose neighborhoods are known: status, radius, tangent frame. For one point, or for as
// many as a vector holds; the operations are the same.

#if defined(CURVD_CORE_ESTIMATORS_FRAMES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#undef CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#endif

#include "core/estimators/frames.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Below this length, the mean of unit normals (or its blend with the point's own) says nothing about a direction: the
// normals of a neighborhood spread over a half sphere still average to 0.5.
inline constexpr float kMinMeanNormal = 0.1f;

using OnePoint = hn::CappedTag<float, 1>;

// Sets the tangent frames `out` of points i, i + 1, ..., a lane each, along the blends of their own and their mean
// normals: u = n x e with e the axis after the largest component of n, v = n x u. Returns which of them have such a
// normal.
template <class D>
HWY_INLINE hn::Mask<D> SetFrames(D d, float average_normal_weight, const GroupNeighborhoods& neighborhoods,
                                 const GroupVectors& normal, size_t i, GroupFrames& out) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V per_count = hn::Div(one, hn::LoadU(d, neighborhoods.count + i));
  const V own_weight = hn::Set(d, 1.0f - average_normal_weight);
  const V mean_weight = hn::Set(d, average_normal_weight);
  const float* own[3] = {normal.x + i, normal.y + i, normal.z + i};
  const float* sum[3] = {neighborhoods.normal_sum.x + i, neighborhoods.normal_sum.y + i,
                         neighborhoods.normal_sum.z + i};
  V n[3] = {zero, zero, zero};
  V squared_mean = zero, squared = zero;
  for (int axis = 0; axis < 3; ++axis) {
    const V mean = hn::Mul(hn::LoadU(d, sum[axis]), per_count);
    n[axis] = hn::Add(hn::Mul(own_weight, hn::LoadU(d, own[axis])), hn::Mul(mean_weight, mean));
    squared_mean = hn::Add(squared_mean, hn::Mul(mean, mean));
    squared = hn::Add(squared, hn::Mul(n[axis], n[axis]));
  }
  const V unit = hn::Div(one, hn::Sqrt(squared));
  for (V& component : n) component = hn::Mul(component, unit);
  // n with its axes turned until the largest component comes first.
  const auto y_over_x = hn::Gt(hn::Abs(n[1]), hn::Abs(n[0]));
  const auto z_largest = hn::Gt(hn::Abs(n[2]), hn::IfThenElse(y_over_x, hn::Abs(n[1]), hn::Abs(n[0])));
  const auto y_largest = hn::AndNot(z_largest, y_over_x);
  const auto turned = [&](V x, V y, V z) { return hn::IfThenElse(z_largest, z, hn::IfThenElse(y_largest, y, x)); };
  const V largest = turned(n[0], n[1], n[2]), next = turned(n[1], n[2], n[0]), last = turned(n[2], n[0], n[1]);
  const V length = hn::Div(one, hn::Sqrt(hn::Add(hn::Mul(last, last), hn::Mul(largest, largest))));
  const V u_largest = hn::Mul(hn::Neg(last), length), u_last = hn::Mul(largest, length);
  const V v_largest = hn::Mul(next, u_last), v_last = hn::Neg(hn::Mul(next, u_largest));
  const V v_next = hn::Sub(hn::Mul(last, u_largest), hn::Mul(largest, u_last));
  // Turned back: what comes first of three lies on the largest axis.
  hn::StoreU(turned(u_largest, u_last, zero), d, out.u.x + i);
  hn::StoreU(turned(zero, u_largest, u_last), d, out.u.y + i);
  hn::StoreU(turned(u_last, zero, u_largest), d, out.u.z + i);
  hn::StoreU(turned(v_largest, v_last, v_next), d, out.v.x + i);
  hn::StoreU(turned(v_next, v_largest, v_last), d, out.v.y + i);
  hn::StoreU(turned(v_last, v_next, v_largest), d, out.v.z + i);
  return hn::Ge(hn::Min(squared_mean, squared), hn::Set(d, kMinMeanNormal * kMinMeanNormal));
}

// Sets the radii `out` of points i, i + 1, ..., a lane each.
template <class D>
HWY_INLINE void SetRadii(D d, const NeighborhoodPlan& plan, const GroupNeighborhoods& neighborhoods, size_t i,
                         GroupFrames& out) {
  const hn::Vec<D> squared = hn::LoadU(d, neighborhoods.squared_radius + i);
  const hn::Vec<D> searched = hn::Sqrt(squared);
  hn::StoreU(hn::Mul(searched, hn::Set(d, plan.rho_factor)), d, out.rho + i);
  hn::StoreU(hn::Div(squared, hn::LoadU(d, neighborhoods.count + i)), d, out.squared_spacing + i);
}

// Squared radii below this are of points that all but coincide beside the rest of the cloud: squares of their offsets
// lose digits, or vanish.
inline constexpr float kMinSquaredRadius = 0x1p-100f;

HWY_INLINE PointStatus StatusOf(const NeighborhoodPlan& plan, float count, float squared_radius, bool has_frame) {
  if (count < static_cast<float>(plan.least_count)) return PointStatus::kTooFewNeighbors;
  if (squared_radius < kMinSquaredRadius) return PointStatus::kDegenerateArea;
  return has_frame ? PointStatus::kOk : PointStatus::kInconsistentNormals;
}

// Sets the status of points i, i + 1, ..., a lane each, their radii and, if kSetsFrames, their tangent frames. Fills
// the frames of those that are not OK, and calls `fill(j)` for them.
template <bool kSetsFrames = true, class D, typename Fill>
HWY_INLINE void PreparePoints(D d, const NeighborhoodPlan& plan, const GroupNeighborhoods& neighborhoods, size_t i,
                              GroupPoints& points, GroupFrames& frames, Fill fill) {
  uint8_t has_frame[8] = {};
  if constexpr (kSetsFrames) {
    const float weight = plan.average_normal_weight;
    hn::StoreMaskBits(d, SetFrames(d, weight, neighborhoods, points.normal, i, frames), has_frame);
  }
  SetRadii(d, plan, neighborhoods, i, frames);
  for (size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    const size_t j = i + lane;
    if (j < points.size) {
      const bool framed = !kSetsFrames || (has_frame[lane / 8] >> (lane % 8) & 1) != 0;
      points.status[j] = StatusOf(plan, neighborhoods.count[j], neighborhoods.squared_radius[j], framed);
      if (points.status[j] == PointStatus::kOk) continue;
    }
    frames.Fill(j);
    fill(j);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
