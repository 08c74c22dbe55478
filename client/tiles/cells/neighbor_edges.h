// Pairs of points that are neighbors: how many a cut parts tells how much its two sides have to share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/tiles/box.h"

namespace curv {

struct NeighborEdge {
  Position a{};
  Position b{};

  // Whether the plane where the coordinate is `cut` lies between the two.
  bool IsCut(size_t axis, double cut) const { return (a[axis] < cut) != (b[axis] < cut); }
};

// Returns an edge from each point to each of its few nearest others. Of points that are drawn at random from a surface,
// a cut parts about as many as the points that lie nearer to it than a neighborhood is large, times a factor that is
// the same for all cuts, whatever the density: denser places have more edges, and shorter ones. Takes O(n log n).
// REQUIRES: the points are finite, fewer than 2^32.
std::vector<NeighborEdge> EdgesOfNeighbors(std::span<const Position> points);

}  // namespace curv
