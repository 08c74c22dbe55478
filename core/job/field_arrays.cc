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

template <const auto& kTable, size_t kIndex, typename Point>
void SplitColumn(std::span<const Point> points, char* out) {
  constexpr Column kColumn = kTable[kIndex];
  for (const Point& point : points) {
    std::memcpy(out, reinterpret_cast<const char*>(&point) + kColumn.offset, kColumn.bytes());
    out += kColumn.bytes();
  }
}

template <const auto& kTable, typename Point, size_t... kIndex>
void SplitColumns(std::span<const Point> points, const std::array<char*, sizeof...(kIndex)>& places,
                  std::index_sequence<kIndex...>) {
  ((places[kIndex] != nullptr ? SplitColumn<kTable, kIndex>(points, places[kIndex]) : void()), ...);
}

}  // namespace

void SplitNormals(std::span<const PointNormal> points, const NormalPlaces& places) {
  SplitColumns<kNormalColumns>(points, places, std::make_index_sequence<kNormalColumns.size()>());
}

void SplitChoices(std::span<const PointChoice> points, const ChoicePlaces& places) {
  SplitColumns<kChoiceColumns>(points, places, std::make_index_sequence<kChoiceColumns.size()>());
}

}  // namespace curvd

#endif  // HWY_ONCE
