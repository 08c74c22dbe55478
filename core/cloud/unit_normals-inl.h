// Checks points and brings their normals to unit length, a point a lane. The operations are those of one point by
// itself (core/cloud/cloud.cc), in doubles: no float's square leaves them.

#if defined(CURVD_CORE_CLOUD_UNIT_NORMALS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_CLOUD_UNIT_NORMALS_INL_H_
#undef CURVD_CORE_CLOUD_UNIT_NORMALS_INL_H_
#else
#define CURVD_CORE_CLOUD_UNIT_NORMALS_INL_H_
#endif

#include <algorithm>
#include <cstring>

#include "core/cloud/unit_normals.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// One multiply turns any infinity into NaN, and a NaN survives the sum.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Mask<D> AllFinite(D d, V x, V y, V z) {
  const V zero = hn::Zero(d);
  return hn::Eq(hn::Add(hn::Add(hn::Mul(x, zero), hn::Mul(y, zero)), hn::Mul(z, zero)), zero);
}

template <class D>
HWY_INLINE uint64_t BitsOf(D d, hn::Mask<D> mask) {
  uint64_t bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<uint8_t*>(&bits));
  return bits;
}

// The same points, followed by points at zero up to the most that are taken at once.
HWY_INLINE const char* Padded(const char* points, size_t count, float* padded) {
  std::memcpy(padded, points, count * 3 * sizeof(float));
  std::fill(padded + 3 * count, padded + 3 * UnitNormals::kMaxPoints, 0.0f);
  return reinterpret_cast<const char*>(padded);
}

inline void MakeUnitNormalsKernel(const char* positions, const char* normals, size_t count, double unit_tolerance,
                                  UnitNormals& out) {
  const hn::CappedTag<double, 8> dd;
  const hn::Rebind<float, decltype(dd)> d;
  constexpr size_t kMax = UnitNormals::kMaxPoints;
  // Whole vectors are read: fewer points get room for them, and what lies there is left out of the bits in the end.
  float padded_positions[kMax * 3], padded_normals[kMax * 3];
  if (count < kMax) {
    positions = Padded(positions, count, padded_positions);
    normals = Padded(normals, count, padded_normals);
  }
  const auto* position = reinterpret_cast<const float*>(positions);
  const auto* normal = reinterpret_cast<const float*>(normals);
  const auto one = hn::Set(dd, 1.0);
  out.usable = out.rescaled = 0;
  for (size_t i = 0; i < count; i += hn::Lanes(dd)) {
    hn::Vec<decltype(d)> px, py, pz, nx, ny, nz;
    hn::LoadInterleaved3(d, position + 3 * i, px, py, pz);
    hn::LoadInterleaved3(d, normal + 3 * i, nx, ny, nz);
    const auto finite = hn::And(AllFinite(d, px, py, pz), AllFinite(d, nx, ny, nz));
    const auto x = hn::PromoteTo(dd, nx), y = hn::PromoteTo(dd, ny), z = hn::PromoteTo(dd, nz);
    const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
    const auto per_length = hn::Div(one, length);
    hn::StoreInterleaved3(hn::DemoteTo(d, hn::Mul(x, per_length)), hn::DemoteTo(d, hn::Mul(y, per_length)),
                          hn::DemoteTo(d, hn::Mul(z, per_length)), d, &out.normals[i][0]);
    const auto off = hn::Abs(hn::Sub(length, one));
    out.usable |= (BitsOf(d, finite) & BitsOf(dd, hn::Gt(length, hn::Zero(dd)))) << i;
    out.rescaled |= BitsOf(dd, hn::Gt(off, hn::Set(dd, unit_tolerance))) << i;
  }
  const uint64_t all = count == kMax ? ~uint64_t{0} : (uint64_t{1} << count) - 1;
  out.usable &= all;
  out.rescaled &= out.usable;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_CLOUD_UNIT_NORMALS_INL_H_
