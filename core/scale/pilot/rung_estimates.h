// Estimates the neighborhoods of one point, from the smallest rung to the largest, by every method.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// Which half of a neighborhood a point of this index in the cloud belongs to.
inline bool IsInEvenHalf(int32_t id) {
  // The finalizer of MurmurHash3: each bit of the index changes each bit of the hash half of the time.
  auto hash = static_cast<uint32_t>(id);
  hash = (hash ^ hash >> 16) * 0x85ebca6bU;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35U;
  return ((hash ^ hash >> 16) & 1) == 0;
}

// Estimates the point of the moment from its neighbors by these methods. REQUIRES: they are as many as the largest rung
// of `rung_count`.
void EstimateRungs(size_t rung_count, const MethodSet& methods, PilotScratch& scratch, PilotPoint& point);

}  // namespace curvd
