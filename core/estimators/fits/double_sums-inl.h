// Sums over neighbors in doubles: dot products of columns, four at a time.

#if defined(CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#endif

#include <cstddef>

#include "core/index/spatial_index.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Half as many lanes as the floats that they come from.
using DoubleTag = hn::CappedTag<double, SpatialIndex::kLeafSize / 2>;
using DoubleVec = hn::Vec<DoubleTag>;
using DoubleMask = hn::Mask<DoubleTag>;

// A vector of points or directions.
struct DoubleTriple {
  DoubleVec x, y, z;
};

HWY_INLINE DoubleVec Widen(const float* from) {
  return hn::PromoteTo(DoubleTag(), hn::Load(hn::Rebind<float, DoubleTag>(), from));
}
HWY_INLINE DoubleTriple Scale(const DoubleTriple& a, DoubleVec s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
// a + s b
HWY_INLINE DoubleTriple AddScaled(const DoubleTriple& a, DoubleVec s, const DoubleTriple& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
HWY_INLINE DoubleVec Dot(const DoubleTriple& a, const DoubleTriple& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void StoreFourSums(DoubleVec a, DoubleVec b, DoubleVec c, DoubleVec e, double* out) {
  out[0] = hn::GetLane(a);
  out[1] = hn::GetLane(b);
  out[2] = hn::GetLane(c);
  out[3] = hn::GetLane(e);
}

#else

// Sum over the blocks of two lanes of a vector.
template <class D>
HWY_INLINE auto SumDoubleBlocks([[maybe_unused]] D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(D()) <= 2) {
    return v;
  } else {
    const hn::Half<D> half;
    return SumDoubleBlocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// Stores the lane sums of four vectors to out[0..3].
HWY_INLINE void StoreFourSums(DoubleVec a, DoubleVec b, DoubleVec c, DoubleVec e, double* out) {
  const DoubleTag d;
  const hn::CappedTag<double, 2> two;
  const DoubleVec ab = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  const DoubleVec ce = hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e));
  hn::StoreU(SumDoubleBlocks(d, ab), two, out);
  hn::StoreU(SumDoubleBlocks(d, ce), two, out + 2);
}

#endif

// Four columns of one number a neighbor, each padded to a whole vector.
struct FourColumns {
  const double* column[4];
};

// Stores the dot products of `left` with each of `right` to out[0..3].
HWY_INLINE void DotFour(const double* left, const FourColumns& right, size_t size, double* out) {
  const DoubleTag d;
  DoubleVec s0 = hn::Zero(d), s1 = hn::Zero(d), s2 = hn::Zero(d), s3 = hn::Zero(d);
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const DoubleVec l = hn::Load(d, left + j);
    s0 = hn::MulAdd(l, hn::Load(d, right.column[0] + j), s0);
    s1 = hn::MulAdd(l, hn::Load(d, right.column[1] + j), s1);
    s2 = hn::MulAdd(l, hn::Load(d, right.column[2] + j), s2);
    s3 = hn::MulAdd(l, hn::Load(d, right.column[3] + j), s3);
  }
  StoreFourSums(s0, s1, s2, s3, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
