// Sums over neighbors in doubles: dot products of columns, four at a time. They are the same in whatever order the
// neighbors come.
//
// A sum that begins at a power of two and a half, the anchor, and stays so near to it that the distance between doubles
// does not change, is rounded to the same whole multiples of that distance, the quantum, in each step. A step adds its
// addend, rounded to the quantum, unless the addend lies just between two multiples: then the sum so far decides. An
// addend whose last bit is set, or a product with such a factor, never does (Odd).

#if defined(CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

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

// The anchor of sums over the lanes of vectors of `count` addends, each of at most `bound` and a millionth of it, which
// is a power of two: all sums are exact in its quanta, those over lanes too.
HWY_INLINE double AnchorOf(size_t count, double bound = 1.0) {
  const auto width = [](size_t n) { return static_cast<int>(std::bit_width(n)); };
  const size_t lanes = hn::Lanes(DoubleTag());
  const int exponent = std::max({width((count + lanes - 1) / lanes) + 1, width(count) - 1, 3});
  return 1.5 * static_cast<double>(uint64_t{1} << exponent) * bound;
}

// A number that is added to another one so that this is not 0, and far below what changes it.
inline constexpr double kNearlyNothing = 0x1p-80;

HWY_INLINE DoubleVec WithLastBit(DoubleVec v) {
  const DoubleTag d;
  const hn::RebindToUnsigned<DoubleTag> bits;
  return hn::BitCast(d, hn::Or(hn::BitCast(bits, v), hn::Set(bits, 1)));
}

// v, which is at most 1 or so, with its last bit set; instead of 0, what no sum notices.
HWY_INLINE DoubleVec Odd(DoubleVec v) { return WithLastBit(hn::Add(v, hn::Set(DoubleTag(), kNearlyNothing))); }

// The same for a b.
HWY_INLINE DoubleVec OddProduct(DoubleVec a, DoubleVec b) {
  return WithLastBit(hn::MulAdd(a, b, hn::Set(DoubleTag(), kNearlyNothing)));
}

// sum + a b. REQUIRES: the sum began at the anchor; a is Odd, or so is b, and neither is above 1 and a millionth.
HWY_INLINE DoubleVec AddProduct(DoubleVec a, DoubleVec b, DoubleVec sum, [[maybe_unused]] DoubleVec anchor) {
#if HWY_NATIVE_FMA
  return hn::MulAdd(a, b, sum);
#else
  // The product is rounded before it is added, and may then lie just between two multiples.
  return hn::Add(sum, hn::Sub(hn::Add(hn::Mul(a, b), anchor), anchor));
#endif
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

// The same for sums that began at the anchor.
HWY_INLINE void StoreAnchoredSums(DoubleVec a, DoubleVec b, DoubleVec c, DoubleVec e, DoubleVec anchor, double* out) {
  StoreFourSums(hn::Sub(a, anchor), hn::Sub(b, anchor), hn::Sub(c, anchor), hn::Sub(e, anchor), out);
}

// Stores the dot products of `left` with each of `right` to out[0..3]. They begin at the anchor of as many numbers or
// more. REQUIRES: of any two numbers that meet, one is Odd or both are 1, and none is above 1 and a millionth.
HWY_INLINE void DotFour(const double* left, const FourColumns& right, size_t size, DoubleVec anchor, double* out) {
  const DoubleTag d;
  DoubleVec s0 = anchor, s1 = anchor, s2 = anchor, s3 = anchor;
  for (size_t j = 0; j < size; j += hn::Lanes(d)) {
    const DoubleVec l = hn::Load(d, left + j);
    s0 = AddProduct(l, hn::Load(d, right.column[0] + j), s0, anchor);
    s1 = AddProduct(l, hn::Load(d, right.column[1] + j), s1, anchor);
    s2 = AddProduct(l, hn::Load(d, right.column[2] + j), s2, anchor);
    s3 = AddProduct(l, hn::Load(d, right.column[3] + j), s3, anchor);
  }
  StoreAnchoredSums(s0, s1, s2, s3, anchor, out);
}

HWY_INLINE void DotFour(const double* left, const FourColumns& right, size_t size, double* out) {
  DotFour(left, right, size, hn::Set(DoubleTag(), AnchorOf(size)), out);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_DOUBLE_SUMS_INL_H_
