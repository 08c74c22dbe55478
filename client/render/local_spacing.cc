#include "client/render/local_spacing.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "client/neighbors/nearest_neighbors.h"
#include "client/neighbors/spatial_order.h"

namespace curv {

std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank) {
  const std::vector<uint32_t> order = SpatialOrder(positions);
  std::vector<Vec3> ordered;
  ordered.reserve(order.size());
  for (const uint32_t i : order) ordered.push_back(positions[i]);
  std::vector<double> spacing(positions.size());
  ForEachNeighborhood(ordered, rank, /*threads=*/0, [&](uint32_t at, std::span<const Neighbor> neighbors) {
    if (!neighbors.empty()) spacing[order[at]] = std::sqrt(neighbors.back().squared_distance);
  });
  return spacing;
}

}  // namespace curv
