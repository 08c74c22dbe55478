#include "client/render/local_spacing.h"

#include <cmath>

#include "client/neighbors/kd_tree.h"

namespace curv {

std::vector<double> LocalSpacing(const std::vector<Vec3>& positions, int rank) {
  std::vector<double> spacing(positions.size());
  KdTree(positions).ForEach(rank, [&](uint32_t i, std::span<const Neighbor> neighbors) {
    if (!neighbors.empty()) spacing[i] = std::sqrt(neighbors.back().squared_distance);
  });
  return spacing;
}

}  // namespace curv
