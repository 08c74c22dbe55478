// What the normals of neighbors say about each other: the edges of the graph along which a cloud is oriented.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/scratch_array.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Neighbors that a point's normal is compared with, and how many they are at most where these lie on lines (LinkProbe).
inline constexpr size_t kLinksPerPoint = 12, kMostLinksPerPoint = 192;

// Says how surely the normals of two points can be compared, and what the comparison says. Points are named by their
// place in the tree order.
struct NormalLink {
  float cost;  // 0: certain; never negative
  uint32_t a;
  uint32_t b : 31;
  uint32_t opposite : 1;  // whether the normals point to different sides of the surface
};

// A total order in which a tree of cheapest links is unique.
inline bool ComesBefore(const NormalLink& x, const NormalLink& y) {
  if (x.cost != y.cost) return x.cost < y.cost;
  return x.a != y.a ? x.a < y.a : x.b < y.b;
}

// The part of a surface that stands for a point, up to a common factor, in two bytes: good to 2^-8.
using PackedArea = uint16_t;
// The factor: a neighborhood of so many points has pi times the area that stands for its middle one.
inline constexpr double kPointsPerArea = 0.5 * (kLinksPerPoint + 1);
PackedArea PackArea(float area);
float UnpackArea(PackedArea area);

// What one thread compares normals with: a group of points at a time.
struct LinkScratch : GroupScratch {
  // Ascending by a, then by b, since neighbors come in the tree order.
  ScratchArray<NormalLink> links;
  size_t link_count = 0;
  // Squared distances of the farthest neighbors of the points from `first_reach` on that were done before: what lies
  // nearer has its link already. The caller sets both.
  ScratchArray<float> reaches;
  size_t first_reach = 0;

  size_t bytes() const override { return sizeof(*this) + search.bytes() + links.bytes() + reaches.bytes(); }
};

// The search for the neighbors that points are compared with. REQUIRES: links_per_point <= kMostLinksPerPoint.
NeighborhoodPlan LinkSearch(const SpatialIndex& index, size_t links_per_point = kLinksPerPoint);

// Appends the links of each point of the group to its neighbors to scratch.links, those left out that scratch.reaches
// tells to be there already, and writes the areas of the points, by place. Points without a normal (NaN) have no links,
// and area 0.
//
// Going around a bend, the normal is mirrored in the plane between the two points (Koenig, Gumhold, "Consistent
// propagation of normal orientations in point clouds", 2009): exactly so on a circle, and also around an edge. Ways
// across the surface cost more than ways along it: in a noisy cloud they say nothing. The cost is the same from both
// points, and on every instruction set.
// Errors: ErrorKind::kCancelled once the scratch is stopped. May throw std::bad_alloc. Thread-safe for distinct scratch
// and groups. REQUIRES: groups come in ascending order; scratch.reaches has room for all places from first_reach to the
// group's last.
absl::Status AppendLinks(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, LinkScratch& scratch,
                         PackedArea* areas);

}  // namespace curvd
