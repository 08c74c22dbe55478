#include "client/render/local_spacing.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "client/neighbors/nearest_neighbors.h"

namespace curv {

std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank) {
  std::vector<double> spacing(positions.size());
  ForEachNeighborhood(positions, rank, /*threads=*/0, [&](uint32_t i, std::span<const Neighbor> neighbors) {
    if (!neighbors.empty()) spacing[i] = std::sqrt(neighbors.back().squared_distance);
  });
  return spacing;
}

}  // namespace curv
