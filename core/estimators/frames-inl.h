// What estimators need of points whose neighborhoods are known: status, radii, tangent frame. For one point, or for as
// many as a vector holds; the operations are the same.

#if defined(CURVD_CORE_ESTIMATORS_FRAMES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#undef CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
#endif

#include "core/estimators/fits/fit_buffers.h"
#include "core/estimators/group_buffers.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Below this length, the mean of unit normals (or its blend with the point's own) says nothing about a direction: the
// normals of a neighborhood spread over a half sphere still average to 0.5.
inline constexpr float kMinMeanNormal = 0.1f;

using OnePoint = hn::CappedTag<float, 1>;

// Sets the tangent frames of points i, i + 1, ..., a lane each, along the blends of their own and their mean normals:
// u = n x e with e the axis after the largest component of n, v = n x u. Returns which of them have such a normal.
template <class D>
HWY_INLINE hn::Mask<D> SetFrames(D d, const EstimationPlan& plan, GroupScratch::Buffers& b, size_t i) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V per_count = hn::Div(one, hn::LoadU(d, b.neighbor_count + i));
  const V own_weight = hn::Set(d, 1.0f - plan.average_normal_weight);
  const V mean_weight = hn::Set(d, plan.average_normal_weight);
  const float* own[3] = {b.normal.x + i, b.normal.y + i, b.normal.z + i};
  const float* sum[3] = {b.normal_sum.x + i, b.normal_sum.y + i, b.normal_sum.z + i};
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
  hn::StoreU(turned(u_largest, u_last, zero), d, b.u.x + i);
  hn::StoreU(turned(zero, u_largest, u_last), d, b.u.y + i);
  hn::StoreU(turned(u_last, zero, u_largest), d, b.u.z + i);
  hn::StoreU(turned(v_largest, v_last, v_next), d, b.v.x + i);
  hn::StoreU(turned(v_next, v_largest, v_last), d, b.v.y + i);
  hn::StoreU(turned(v_last, v_next, v_largest), d, b.v.z + i);
  return hn::Ge(hn::Min(squared_mean, squared), hn::Set(d, kMinMeanNormal * kMinMeanNormal));
}

// Sets the radii of points i, i + 1, ..., a lane each.
template <class D>
HWY_INLINE void SetRadii(D d, const EstimationPlan& plan, GroupScratch::Buffers& b, size_t i) {
  const hn::Vec<D> squared = hn::LoadU(d, b.squared_radius + i);
  const hn::Vec<D> searched = hn::Sqrt(squared);
  hn::StoreU(hn::Mul(searched, hn::Set(d, plan.radius_factor)), d, b.radius + i);
  hn::StoreU(hn::Mul(searched, hn::Set(d, plan.rho_factor)), d, b.rho + i);
  hn::StoreU(hn::Div(squared, hn::LoadU(d, b.neighbor_count + i)), d, b.squared_spacing + i);
}

// A point that will not be estimated takes values that no kernel trips over.
HWY_INLINE void FillPoint(GroupScratch::Buffers& b, size_t i) {
  constexpr float kX[3] = {1.0f, 0.0f, 0.0f}, kY[3] = {0.0f, 1.0f, 0.0f};
  b.u.Set(i, kX);
  b.v.Set(i, kY);
  b.rho[i] = b.radius[i] = 1.0f;
  b.squared_spacing[i] = 0.0f;
  for (Hexagram& hexagram : b.hexagrams) hexagram.Clear(i);
  GroupMeasures& m = b.measures;
  m.area[i] = m.mean[i] = m.gaussian[i] = m.tensor_uu[i] = m.tensor_uv[i] = m.tensor_vv[i] = 0.0f;
}

HWY_INLINE PointStatus StatusOf(const EstimationPlan& plan, float count, float squared_radius, bool has_frame) {
  const size_t least = plan.by_radius ? kMinNeighborCount : plan.searched_count;
  if (count < static_cast<float>(least)) return PointStatus::kTooFewNeighbors;
  if (squared_radius <= 0.0f) return PointStatus::kDegenerateArea;
  if (plan.estimator == EstimatorKind::kJetFitting) {
    return count < static_cast<float>(JetSize(plan.jet_degree)) ? PointStatus::kSingularFit : PointStatus::kOk;
  }
  return has_frame ? PointStatus::kOk : PointStatus::kInconsistentNormals;
}

// Sets the status of points i, i + 1, ..., a lane each, and their frames and radii. Jets find frames of their own.
template <class D>
HWY_INLINE void PreparePoints(D d, const EstimationPlan& plan, GroupScratch::Buffers& b, size_t i) {
  uint8_t has_frame[8] = {};
  if (plan.estimator != EstimatorKind::kJetFitting) hn::StoreMaskBits(d, SetFrames(d, plan, b, i), has_frame);
  SetRadii(d, plan, b, i);
  for (size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    const size_t j = i + lane;
    if (j < b.size) {
      const bool framed = (has_frame[lane / 8] >> (lane % 8) & 1) != 0;
      b.status[j] = StatusOf(plan, b.neighbor_count[j], b.squared_radius[j], framed);
      if (b.status[j] == PointStatus::kOk) continue;
    }
    FillPoint(b, j);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FRAMES_INL_H_
