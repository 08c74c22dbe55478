#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/delaunay/umbrella.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/delaunay/occurrences-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include "core/estimators/delaunay/umbrella.h"

namespace curvd {

HWY_EXPORT(CountOccurrencesKernel);

void CountOccurrences(Umbrella* umbrellas, size_t first, size_t last) {
  HWY_DYNAMIC_DISPATCH(CountOccurrencesKernel)(umbrellas, first, last);
}

}  // namespace curvd

#endif  // HWY_ONCE
