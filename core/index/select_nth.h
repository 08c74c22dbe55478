// Selection on point records: the step that a kd-tree's build repeats.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/stop_sign.h"
#include "core/cloud/point_record.h"

namespace curvd {

// Ranges up to this size are sorted by ranking.
inline constexpr size_t kRankedRecords = 64;

// Records that are partitioned between two looks at a StopSign, in 20 milliseconds; and at most without one.
inline constexpr size_t kSlicedRecords = size_t{4} << 20;
inline constexpr size_t kUnslicedRecords = size_t{1} << 16;

// Reorders [first, last) so that every record before `nth` is less than every record from `nth` on, by coordinate
// `axis` and then by id. Records have distinct ids, so the result's two sides are unique; their inner order depends on
// the instruction set. Expected linear time; at most about 200 passes over the records, whatever they are.
// Asks `stop` before each slice of up to kSlicedRecords, and returns, the records in any order, once it is set: after
// that slice, or kUnslicedRecords more.
// REQUIRES: first <= nth <= last; coordinates are not NaN; ids are not negative.
void SelectNth(PointRecord* first, PointRecord* nth, PointRecord* last, int axis, StopSign stop = {});

}  // namespace curvd
