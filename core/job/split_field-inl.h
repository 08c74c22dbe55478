// Transposes points of a field, four at a time.

#if defined(CURVD_CORE_JOB_SPLIT_FIELD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#undef CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#else
#define CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#endif

#include <cstddef>
#include <cstring>
#include <span>

#include "core/job/field_arrays.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <typename Field>
HWY_INLINE void CopyField(const Field& field, size_t i, char* out) {
  if (out != nullptr) std::memcpy(out + i * sizeof(Field), &field, sizeof(Field));
}

HWY_INLINE void SplitPoint(const PointCurvature& point, size_t i, const FieldArrays& out) {
  CopyField(point.mean, i, out.mean);
  CopyField(point.gaussian, i, out.gaussian);
  CopyField(point.k1, i, out.k1);
  CopyField(point.k2, i, out.k2);
  CopyField(point.d1, i, out.d1);
  CopyField(point.d2, i, out.d2);
  CopyField(point.radius, i, out.radius);
  CopyField(point.status, i, out.status);
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE size_t SplitByFours(std::span<const PointCurvature> /*points*/, const FieldArrays& /*out*/) { return 0; }

#else

// A point is three vectors: mean, gaussian, k1, k2 | d1, d2.x | d2.y, d2.z, radius, status.
static_assert(sizeof(PointCurvature) == 48 && offsetof(PointCurvature, mean) == 0 &&
              offsetof(PointCurvature, gaussian) == 4 && offsetof(PointCurvature, k1) == 8 &&
              offsetof(PointCurvature, k2) == 12 && offsetof(PointCurvature, d1) == 16 &&
              offsetof(PointCurvature, d2) == 28 && offsetof(PointCurvature, radius) == 40 &&
              offsetof(PointCurvature, status) == 44);

// The first two columns of four rows, given as the interleaved lower halves of rows 0 and 1, and of rows 2 and 3 (or as
// the upper halves, for the last two columns), to place `i` of two arrays of floats.
template <class D, class V>
HWY_INLINE void StoreColumns(D d, V rows01, V rows23, size_t i, char* first, char* second) {
  const size_t at = i * sizeof(float);
  if (first != nullptr) hn::StoreU(hn::ConcatLowerLower(d, rows23, rows01), d, reinterpret_cast<float*>(first + at));
  if (second != nullptr) hn::StoreU(hn::ConcatUpperUpper(d, rows23, rows01), d, reinterpret_cast<float*>(second + at));
}

// Points [i, i + 4). Writes a float too many behind d1 and d2.
HWY_INLINE void SplitFour(const PointCurvature* points, size_t i, const FieldArrays& out) {
  const hn::FixedTag<float, 4> d;
  using V = hn::Vec<decltype(d)>;
  const auto load = [&](size_t point, size_t part) HWY_ATTR {
    return hn::LoadU(d, reinterpret_cast<const float*>(&points[i + point]) + 4 * part);
  };
  const V a0 = load(0, 0), a1 = load(1, 0), a2 = load(2, 0), a3 = load(3, 0);
  StoreColumns(d, hn::InterleaveLower(d, a0, a1), hn::InterleaveLower(d, a2, a3), i, out.mean, out.gaussian);
  StoreColumns(d, hn::InterleaveUpper(d, a0, a1), hn::InterleaveUpper(d, a2, a3), i, out.k1, out.k2);
  const V c[4] = {load(0, 2), load(1, 2), load(2, 2), load(3, 2)};
  StoreColumns(d, hn::InterleaveUpper(d, c[0], c[1]), hn::InterleaveUpper(d, c[2], c[3]), i, out.radius, nullptr);
  // In this order: the float too many lies where the next point's direction goes.
  for (size_t point = 0; point < 4; ++point) {
    const V b = load(point, 1);
    const size_t at = 3 * sizeof(float) * (i + point);
    if (out.d1 != nullptr) hn::StoreU(b, d, reinterpret_cast<float*>(out.d1 + at));
    if (out.d2 != nullptr) {
      hn::StoreU(hn::CombineShiftRightBytes<12>(d, c[point], b), d, reinterpret_cast<float*>(out.d2 + at));
    }
    CopyField(points[i + point].status, i + point, out.status);
  }
}

// Returns how many points it split; never all of them.
HWY_INLINE size_t SplitByFours(std::span<const PointCurvature> points, const FieldArrays& out) {
  size_t i = 0;
  for (; i + 4 < points.size(); i += 4) SplitFour(points.data(), i, out);
  return i;
}

#endif

inline void SplitFieldKernel(std::span<const PointCurvature> points, const FieldArrays& out) {
  for (size_t i = SplitByFours(points, out); i < points.size(); ++i) SplitPoint(points[i], i, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
