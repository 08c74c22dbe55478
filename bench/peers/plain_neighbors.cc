#include <cmath>

#include "bench/peers/packed_points.h"
#include "bench/peers/plain_peers.h"

namespace curvd::bench {

PeerNeighbors FindPeerNeighbors(const PeerCloud& cloud, size_t k, size_t points) {
  const PackedPoints<double> packed{cloud.positions.data(), cloud.size()};
  NanoflannTree<double> tree(3, packed, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  PeerNeighbors neighbors{k, std::vector<uint32_t>(points * k), std::vector<double>(points)};
  std::vector<double> squared_distances(k);
  for (size_t i = 0; i < points; ++i) {
    tree.knnSearch(&cloud.positions[3 * i], k, &neighbors.indices[i * k], squared_distances.data());
    neighbors.radii[i] = std::sqrt(squared_distances[k - 1]);
  }
  return neighbors;
}

}  // namespace curvd::bench
