// The sums of OffsetSums (core/estimators/lines/offset_sums.h) over vectors of neighbors: the same, to the bit.

#if defined(CURVD_CORE_ESTIMATORS_LINES_OFFSET_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_LINES_OFFSET_SUMS_INL_H_
#undef CURVD_CORE_ESTIMATORS_LINES_OFFSET_SUMS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_LINES_OFFSET_SUMS_INL_H_
#endif

#include <array>
#include <cstddef>

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/lines/offset_sums.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Each product and each sum is rounded, as in scalar code.
HWY_INLINE DoubleVec RoundedDot(const DoubleTriple& a, const DoubleTriple& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

// `kCount` sums of addends of at most 1 or so, of up to 2^27 neighbors.
template <size_t kCount>
class VectorOffsetSums {
 public:
  VectorOffsetSums() {
    for (QuantaVec& sum : sums_) sum = hn::Zero(QuantaTag());
  }
  HWY_INLINE void Add(const DoubleVec (&addends)[kCount]) {
    const DoubleTag d;
    const DoubleVec per_quantum = hn::Set(d, OffsetQuanta::kPerUnit), whole = hn::Set(d, OffsetQuanta::kWholeNumbers);
    for (size_t s = 0; s < kCount; ++s) {
      const DoubleVec rounded = hn::Add(hn::Mul(addends[s], per_quantum), whole);
      sums_[s] = hn::Add(sums_[s], hn::Sub(hn::BitCast(QuantaTag(), rounded), hn::BitCast(QuantaTag(), whole)));
    }
  }
  std::array<double, kCount> Total() const {
    std::array<double, kCount> total;
    for (size_t s = 0; s < kCount; ++s) {
      total[s] = static_cast<double>(hn::GetLane(hn::SumOfLanes(QuantaTag(), sums_[s]))) / OffsetQuanta::kPerUnit;
    }
    return total;
  }

 private:
  using QuantaTag = hn::RebindToSigned<DoubleTag>;
  using QuantaVec = hn::Vec<QuantaTag>;

  QuantaVec sums_[kCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_LINES_OFFSET_SUMS_INL_H_
