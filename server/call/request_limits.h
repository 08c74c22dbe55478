// Says what one call may ask of this server.
#pragma once

#include <algorithm>
#include <cstdint>

#include "server/access/caller.h"

namespace curvd {

// The resolved form of the limits in ServerOptions; what curvature.v1.ServerLimits tells.
struct CallLimits {
  uint64_t max_points = 0;
  uint64_t max_chunk_bytes = 0;
  uint32_t max_neighbor_count = 0;
  uint64_t memory_bytes = 0;
  uint32_t max_streams = 0;
};

// `limits` with those of the caller where they are tighter.
inline CallLimits LimitsFor(const Caller& caller, CallLimits limits) {
  if (caller.max_points != 0) limits.max_points = std::min(limits.max_points, caller.max_points);
  if (caller.max_streams != 0) limits.max_streams = std::min(limits.max_streams, caller.max_streams);
  return limits;
}

}  // namespace curvd
