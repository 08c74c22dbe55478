// What one call may ask of this server.
#pragma once

#include <cstdint>

namespace curvd {

// The resolved form of the limits in ServerOptions; what curvature.v1.ServerLimits tells.
struct CallLimits {
  uint64_t max_points = 0;
  uint64_t max_chunk_bytes = 0;
  uint32_t max_neighbor_count = 0;
  uint64_t memory_bytes = 0;
  uint32_t max_streams = 0;
};

}  // namespace curvd
