// Sums of floats that are the same in whatever order they run: each addend becomes a whole number of quanta, and
// integers are added. What a number becomes depends on itself and on the quantum, which follows from a bound of the
// addends and from their number; so a sum depends on what is added alone, and not on where in the tree it lies.

#if defined(CURVD_CORE_ESTIMATORS_FIXED_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FIXED_POINT_INL_H_
#undef CURVD_CORE_ESTIMATORS_FIXED_POINT_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FIXED_POINT_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Added to a float of at most 2^22, this leaves the nearest whole number in the low bits of the sum: sums of such bits,
// less as many times those of this, are sums of whole numbers, modulo 2^32.
inline constexpr float kFixedPoint = 0x1.8p23f;
inline constexpr uint32_t kFixedPointBits = std::bit_cast<uint32_t>(kFixedPoint);

// Bits of a whole number of which `count` may be added up in an int32_t, at most those that kFixedPoint leaves.
HWY_INLINE int FixedPointBits(size_t count) { return std::min(22, 31 - static_cast<int>(std::bit_width(count))); }

// REQUIRES: from -126 to 127.
HWY_INLINE float PowerOfTwo(int exponent) { return std::bit_cast<float>((127 + exponent) << 23); }

// The exponent of a power of two that is above the root of a number. REQUIRES: it is a normal float > 0.
HWY_INLINE int RootExponent(float squared) {
  const int exponent = (std::bit_cast<int32_t>(squared) >> 23) - 126;
  return (exponent + 1) >> 1;
}

// Whole quanta of a vector of floats, as the bits of kFixedPoint plus them. `per_quantum` is a power of two.
HWY_INLINE hn::Vec<IntTag> ToFixedPoint(FloatVec v, FloatVec per_quantum) {
  const FloatTag d;
  return hn::BitCast(IntTag(), hn::MulAdd(v, per_quantum, hn::Set(d, kFixedPoint)));
}

// The sum of the lanes, modulo 2^32.
HWY_INLINE uint32_t SumOfBits(hn::Vec<IntTag> v) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  // The intrinsic that would add all lanes adds signed numbers, whose overflow is undefined; vectors wrap around.
  const hn::Half<IntTag> half;
  const auto pairs = hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v));
  return static_cast<uint32_t>(hn::GetLane(hn::SumOfLanes(half, pairs)));
#else
  return static_cast<uint32_t>(hn::GetLane(hn::SumOfLanes(IntTag(), v)));
#endif
}

// Sums vectors of unit length.
class UnitVectorSums {
 public:
  HWY_INLINE UnitVectorSums() { Start(1); }
  // `count`: as many are added at most.
  HWY_INLINE void Start(size_t count) {
    x_ = y_ = z_ = hn::Zero(IntTag());
    exponent_ = FixedPointBits(count);
    per_quantum_ = hn::Set(FloatTag(), PowerOfTwo(exponent_));
  }
  HWY_INLINE void Add(FloatVec x, FloatVec y, FloatVec z) {
    x_ = hn::Add(x_, ToFixedPoint(x, per_quantum_));
    y_ = hn::Add(y_, ToFixedPoint(y, per_quantum_));
    z_ = hn::Add(z_, ToFixedPoint(z, per_quantum_));
  }
  HWY_INLINE void AddWhere(FloatMask mask, FloatVec x, FloatVec y, FloatVec z) {
    const auto where = hn::RebindMask(IntTag(), mask);
    AddIntWhere(where, ToFixedPoint(x, per_quantum_), x_);
    AddIntWhere(where, ToFixedPoint(y, per_quantum_), y_);
    AddIntWhere(where, ToFixedPoint(z, per_quantum_), z_);
  }
  // Stores the sum of the `added` vectors, those of length 0 among them.
  HWY_INLINE void Store(size_t added, float* sum) const {
    const float quantum = PowerOfTwo(-exponent_);
    const auto total = [&](hn::Vec<IntTag> v) HWY_ATTR {
      return static_cast<float>(static_cast<int32_t>(SumOfBits(v) - static_cast<uint32_t>(added) * kFixedPointBits)) *
             quantum;
    };
    sum[0] = total(x_);
    sum[1] = total(y_);
    sum[2] = total(z_);
  }

 private:
  static HWY_INLINE void AddIntWhere(hn::Mask<IntTag> mask, hn::Vec<IntTag> v, hn::Vec<IntTag>& sum) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    sum = hn::IfThenElse(mask, hn::Add(sum, v), sum);  // one masked instruction
#else
    sum = hn::Add(sum, hn::IfThenElseZero(mask, v));
#endif
  }

  hn::Vec<IntTag> x_, y_, z_;
  FloatVec per_quantum_;
  int exponent_;
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FIXED_POINT_INL_H_
