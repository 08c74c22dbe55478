// In how many umbrellas each triangle occurs.

#if defined(CURVD_CORE_ESTIMATORS_DELAUNAY_OCCURRENCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_DELAUNAY_OCCURRENCES_INL_H_
#undef CURVD_CORE_ESTIMATORS_DELAUNAY_OCCURRENCES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_DELAUNAY_OCCURRENCES_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/estimators/delaunay/umbrella.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Whether the umbrella has the triangle over `a` and `b`, whichever way round: normals may face opposite sides.
// Compares the whole rim: an early end would be a branch that nobody can predict. Keeps off what follows the rim, which
// another thread may be writing.
HWY_INLINE bool HasTriangle(const Umbrella& umbrella, int32_t a, int32_t b) {
  const hn::CappedTag<int32_t, 8> d;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(hn::CappedTag<int32_t, 8>()));
  const auto first = hn::Set(d, a), second = hn::Set(d, b);
  auto found = hn::FirstN(d, 0);
  for (int i = 0; i < Umbrella::kMaxTriangles; i += kLanes) {
    const int32_t* rim = umbrella.rim + std::min(i, Umbrella::kMaxTriangles - kLanes);
    const auto corner = hn::LoadU(d, rim), next = hn::LoadU(d, rim + 1);
    found = hn::Or(found, hn::Or(hn::And(hn::Eq(corner, first), hn::Eq(next, second)),
                                 hn::And(hn::Eq(corner, second), hn::Eq(next, first))));
  }
  return !hn::AllFalse(d, found);
}

void CountOccurrencesKernel(Umbrella* umbrellas, size_t first, size_t last) {
  for (size_t place = first; place < last; ++place) {
    Umbrella& umbrella = umbrellas[place];
    const auto point = static_cast<int32_t>(place);
    uint32_t occurrences = 0;
    for (int i = 0; i < Umbrella::kMaxTriangles && umbrella.rim[i + 1] != Umbrella::kNone; ++i) {
      const int32_t low = std::min(umbrella.rim[i], umbrella.rim[i + 1]);
      const int32_t high = std::max(umbrella.rim[i], umbrella.rim[i + 1]);
      const bool at_low = HasTriangle(umbrellas[low], high, point);
      if (at_low && low < point) continue;
      const bool at_high = HasTriangle(umbrellas[high], point, low);
      if (at_high && high < point) continue;
      occurrences |= static_cast<uint32_t>(1 + at_low + at_high) << (2 * i);
    }
    umbrella.occurrences = occurrences;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_DELAUNAY_OCCURRENCES_INL_H_
