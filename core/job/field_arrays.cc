#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/job/field_arrays.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/job/split_field-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <cstring>
#include <utility>

#include "core/job/field_arrays.h"

namespace curvd {

HWY_EXPORT(SplitFieldKernel);

void SplitField(std::span<const PointCurvature> points, const ColumnPlaces& places) {
  HWY_DYNAMIC_DISPATCH(SplitFieldKernel)(points, places);
}

namespace {

template <size_t kIndex>
void SplitColumn(std::span<const PointNormal> points, char* out) {
  constexpr size_t kBytes = kNormalColumns[kIndex].bytes();
  for (const PointNormal& point : points) {
    std::memcpy(out, reinterpret_cast<const char*>(&point) + kNormalColumns[kIndex].offset, kBytes);
    out += kBytes;
  }
}

template <size_t... kIndex>
void SplitColumns(std::span<const PointNormal> points, const NormalPlaces& places, std::index_sequence<kIndex...>) {
  ((places[kIndex] != nullptr ? SplitColumn<kIndex>(points, places[kIndex]) : void()), ...);
}

}  // namespace

void SplitNormals(std::span<const PointNormal> points, const NormalPlaces& places) {
  SplitColumns(points, places, std::make_index_sequence<kNormalColumns.size()>());
}

}  // namespace curvd

#endif  // HWY_ONCE
