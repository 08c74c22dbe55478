#include "client/tiles/cells/neighbor_edges.h"

#include "client/neighbors/nearest_neighbors.h"

namespace curv {

std::vector<NeighborEdge> EdgesOfNeighbors(std::span<const Position> points) {
  constexpr int kNeighbors = 6;  // as triangulations have
  std::vector<Vec3> positions;
  positions.reserve(points.size());
  for (const Position& p : points) positions.push_back({p[0], p[1], p[2]});
  std::vector<NeighborEdge> edges;
  edges.reserve(points.size() * kNeighbors);
  const auto add = [&](uint32_t i, std::span<const Neighbor> neighbors) {
    for (const Neighbor& neighbor : neighbors) edges.push_back({points[i], points[neighbor.index]});
  };
  ForEachNeighborhood(positions, kNeighbors, /*threads=*/1, add);
  return edges;
}

}  // namespace curv
