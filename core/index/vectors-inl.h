// The vectors that all kernels work with, and what Highway lacks for them.

// Toggled so that each instruction set compiles its own copy.
#if defined(CURVD_CORE_INDEX_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_INDEX_VECTORS_INL_H_
#undef CURVD_CORE_INDEX_VECTORS_INL_H_
#else
#define CURVD_CORE_INDEX_VECTORS_INL_H_
#endif

#include <cstdint>

#include "core/index/spatial_index.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// At most one leaf a vector, so that a leaf is a whole number of vectors on every machine.
using FloatTag = hn::CappedTag<float, SpatialIndex::kLeafSize>;
using IntTag = hn::RebindToSigned<FloatTag>;
using FloatVec = hn::Vec<FloatTag>;
using FloatMask = hn::Mask<FloatTag>;

HWY_INLINE FloatMask MaskFromBits(uint64_t bits) {
  return hn::LoadMaskBits(FloatTag(), reinterpret_cast<const uint8_t*>(&bits));
}

HWY_INLINE uint64_t BitsFromMask(FloatMask mask) {
  uint64_t bits = 0;
  hn::StoreMaskBits(FloatTag(), mask, reinterpret_cast<uint8_t*>(&bits));
  return bits;
}

// first, first + 1, ... A constant and an addition: Highway's Iota of a variable goes through memory, lane by lane.
HWY_INLINE hn::Vec<IntTag> IntsFrom(int32_t first) {
  const IntTag d;
  return hn::Add(hn::Iota(d, 0), hn::Set(d, first));
}

// sum + x where the mask is set, sum elsewhere.
HWY_INLINE FloatVec AddWhere(FloatMask mask, FloatVec sum, FloatVec x) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return hn::IfThenElse(mask, hn::Add(sum, x), sum);  // one masked instruction
#else
  return hn::Add(sum, hn::IfThenElseZero(mask, x));
#endif
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void StoreFourSums(FloatVec a, FloatVec b, FloatVec c, FloatVec e, float* out) {
  out[0] = hn::GetLane(a);
  out[1] = hn::GetLane(b);
  out[2] = hn::GetLane(c);
  out[3] = hn::GetLane(e);
}

#else

// Sum over the blocks of four lanes of a vector.
template <class D>
HWY_INLINE auto SumBlocks([[maybe_unused]] D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(D()) <= 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return SumBlocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// Stores the lane sums of four vectors to out[0..3], by a transposition of their blocks.
HWY_INLINE void StoreFourSums(FloatVec a, FloatVec b, FloatVec c, FloatVec e, float* out) {
  const FloatTag d;
  const hn::RepartitionToWide<FloatTag> wide;
  const FloatVec ab = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  const FloatVec ce = hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e));
  const auto low = hn::InterleaveLower(wide, hn::BitCast(wide, ab), hn::BitCast(wide, ce));
  const auto high = hn::InterleaveUpper(wide, hn::BitCast(wide, ab), hn::BitCast(wide, ce));
  hn::StoreU(SumBlocks(d, hn::Add(hn::BitCast(d, low), hn::BitCast(d, high))), hn::CappedTag<float, 4>(), out);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_INDEX_VECTORS_INL_H_
