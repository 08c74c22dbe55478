// Estimates the neighborhoods of one point, from the smallest rung to the largest, by every method.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// Estimates the point of the moment from its neighbors by these methods. REQUIRES: they are as many as the largest rung
// of `rung_count`.
void EstimateRungs(size_t rung_count, const MethodSet& methods, PilotScratch& scratch, PilotPoint& point);

}  // namespace curvd
