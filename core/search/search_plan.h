// What a search is asked for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace curvd {

// Which points are neighbors of a query: a number of nearest points, or all within a radius. Lengths are in the index's
// unit.
struct SearchPlan {
  bool by_radius = false;
  // By count: how many points to find, the query itself included; equal distances go to the lower id.
  // REQUIRES: from 1 to index.point_count().
  size_t searched_count = 0;
  // By radius: all points at most this squared distance away.
  float squared_radius = 0.0f;
  // By radius: a neighborhood of more points is given up while it is collected.
  size_t max_neighbor_count = std::numeric_limits<uint32_t>::max();

  static SearchPlan ByCount(size_t count) { return {.searched_count = count}; }
  static SearchPlan ByRadius(float squared_radius, size_t max_neighbor_count) {
    return {.by_radius = true, .squared_radius = squared_radius, .max_neighbor_count = max_neighbor_count};
  }

  // Most points that the search may find, in an index of `point_count` points.
  size_t MostNeighbors(size_t point_count) const {
    return std::min(by_radius ? max_neighbor_count : searched_count, point_count);
  }

  // Leaves that one list for all queries of a group may hold: a longer one costs more to cull for each query than a
  // descent of the tree.
  size_t max_listed_leaves() const { return (by_radius ? max_neighbor_count : searched_count) / 2 + 192; }
};

}  // namespace curvd
