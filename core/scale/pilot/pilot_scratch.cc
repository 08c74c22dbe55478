#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

size_t PilotScratch::bytes() const {
  return CollectScratch::bytes() - sizeof(CollectScratch) + sizeof(*this) + order.capacity() * sizeof(uint32_t) +
         (keys.capacity() + other_keys.capacity()) * sizeof(uint64_t) + squared.capacity() * sizeof(float) +
         normals.capacity() * sizeof(NeighborNormal) + tied.capacity() * sizeof(uint32_t) +
         (rims[0].capacity() + rims[1].capacity() + rims[2].capacity()) * sizeof(PilotNeighbor);
}

size_t PilotScratch::MostBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t most = MostNeighbors(options, point_count);
  return CollectScratch::MostBytes(options, point_count) - sizeof(CollectScratch) + sizeof(PilotScratch) +
         most * (3 * sizeof(uint32_t) + sizeof(float) + 2 * sizeof(uint64_t) + 2 * sizeof(NeighborNormal)) +
         kMostAtRim * PilotPoint::kParts * sizeof(PilotNeighbor);
}

}  // namespace curvd
