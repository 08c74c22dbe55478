// Selection on point records: the step that a kd-tree's build repeats.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/cloud/point_record.h"

namespace curvd {

// Ranges up to this size are sorted by ranking.
inline constexpr size_t kRankedRecords = 64;

// Reorders [first, last) so that every record before `nth` is less than every record from `nth` on, by coordinate
// `axis` and then by id. Records have distinct ids, so the result's two sides are unique; their inner order depends on
// the instruction set. Expected linear time, worst case n log n.
// Returns within tens of milliseconds, the records in any order, once `cancelled` (if there is one) is true.
// REQUIRES: first <= nth <= last; coordinates are not NaN.
void SelectNth(PointRecord* first, PointRecord* nth, PointRecord* last, int axis,
               const std::atomic<bool>* cancelled = nullptr);

}  // namespace curvd
