// The local Delaunay umbrella of a point (Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes, SGP 2020): the
// triangles at the point in the Delaunay triangulation of its nearest neighbors, projected to its tangent plane.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/estimators/group_scratch.h"
#include "core/index/spatial_index.h"
#include "core/search/search_plan.h"

namespace curvd {

// Neighbors that an umbrella is made from, the point itself not counted.
inline constexpr int kUmbrellaNeighbors = 30;

// One cache line. Points are named by their place in the tree order: leaf * SpatialIndex::kLeafSize + lane, the place
// in the leaf.
struct alignas(64) Umbrella {
  static constexpr int kMaxRim = 15;
  static constexpr int kMaxTriangles = kMaxRim - 1;
  static constexpr int32_t kNone = -1;

  // The outer corners, counterclockwise seen against the point's normal; each two in a row make a triangle with the
  // point. One that goes all around ends with the corner that it starts with; one with a gap starts behind it. The rest
  // is kNone. Of more than kMaxTriangles triangles those are kept that follow the nearest neighbor.
  int32_t rim[kMaxRim];
  // Two bits a triangle, from the lowest: in how many umbrellas it occurs (1 to 3) if this one's point has the lowest
  // place of those, else 0. So that a walk over all umbrellas meets each distinct triangle once.
  uint32_t occurrences;

  int Occurrences(int triangle) const { return static_cast<int>(occurrences >> (2 * triangle) & 3); }
};
static_assert(sizeof(Umbrella) == 64);

// The search for the neighbors that umbrellas are made from.
SearchPlan UmbrellaSearch(const SpatialIndex& index);

// Sets the rims of the umbrellas of the points of group `group`, from scratch.first_point on; `umbrellas` holds those
// of the whole cloud, by place. An umbrella takes its search and at most Umbrella::kMaxRim + 2 looks at each of its
// neighbors, whatever the cloud. Thread-safe for distinct scratch and groups.
void BuildUmbrellas(const SpatialIndex& index, const SearchPlan& plan, size_t group, GroupScratch& scratch,
                    Umbrella* umbrellas);

// Sets the occurrences of the triangles of the umbrellas at places [first, last). The rims of all must be complete.
// Thread-safe for distinct places.
void CountOccurrences(Umbrella* umbrellas, size_t first, size_t last);

}  // namespace curvd
