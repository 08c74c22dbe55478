#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/job/field_arrays.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/job/split_field-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include "core/job/field_arrays.h"

namespace curvd {

HWY_EXPORT(SplitFieldKernel);

void SplitField(std::span<const PointCurvature> points, const ColumnPlaces& places) {
  HWY_DYNAMIC_DISPATCH(SplitFieldKernel)(points, places);
}

}  // namespace curvd

#endif  // HWY_ONCE
