#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/delaunay/umbrella.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/delaunay/occurrences-inl.h"
#include "core/estimators/delaunay/umbrella-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>

#include "core/estimators/delaunay/umbrella.h"

namespace curvd {

HWY_EXPORT(BuildUmbrellasKernel);
HWY_EXPORT(CountOccurrencesKernel);

SearchPlan UmbrellaSearch(const SpatialIndex& index) {
  return SearchPlan::ByCount(std::min<size_t>(kUmbrellaNeighbors + 1, index.point_count()));
}

void BuildUmbrellas(const SpatialIndex& index, const SearchPlan& plan, size_t group, GroupScratch& scratch,
                    Umbrella* umbrellas) {
  HWY_DYNAMIC_DISPATCH(BuildUmbrellasKernel)(index, plan, group, scratch, umbrellas);
}

void CountOccurrences(Umbrella* umbrellas, size_t first, size_t last) {
  HWY_DYNAMIC_DISPATCH(CountOccurrencesKernel)(umbrellas, first, last);
}

}  // namespace curvd

#endif  // HWY_ONCE
