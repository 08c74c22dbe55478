// The nearest neighbors of each point of a group, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/estimators/group_points.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/search/search_scratch.h"

namespace curvd {

// A neighbor, by its place in the tree order, and its squared distance in the index's unit.
struct NearestPoint {
  float squared_distance;
  uint32_t place;
};

struct NearestScratch final : WorkerScratch {
  // Neighbors of a point that are found, the point itself not among them.
  static constexpr size_t kNearest = 32;
  // With room for the point, and for a vector more.
  static constexpr size_t kRoom = kNearest + 1 + size_t{2} * SpatialIndex::kLeafSize;

  SearchScratch search;
  GroupPoints points;
  alignas(64) float squared_distances[kRoom];
  alignas(64) int32_t places[kRoom];
  alignas(64) int32_t order[kRoom];
  NearestPoint neighbors[kNearest + 1];
  // Whether the last group looked as if few neighbors tell of most points what matters. Only time depends on it: what
  // few neighbors settle, more of them leave as it is.
  bool may_look_at_few = true;

  size_t bytes() const override { return sizeof(*this) + search.bytes(); }
  uint64_t work() const override { return search.work; }
};

// Calls visit(i, neighbors) for the points of the group that get a result and are wanted, from scratch.first_point on:
// i is a place in scratch.points, is_wanted(place) is asked of that in the tree order, and neighbors are the `nearest`
// ones, or all others of a small cloud, in ascending order. Errors as those of GroupPhase::run. Thread-safe for
// distinct scratch. REQUIRES: nearest <= kNearest.
absl::Status ForEachNearest(const SpatialIndex& index, size_t group, size_t nearest, NearestScratch& scratch,
                            absl::FunctionRef<bool(size_t place)> is_wanted,
                            absl::FunctionRef<void(size_t i, std::span<const NearestPoint> neighbors)> visit);

}  // namespace curvd
