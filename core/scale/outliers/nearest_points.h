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

struct NearestScratch final : WorkerScratch {
  // Neighbors of a point that are found, the point itself not among them.
  static constexpr size_t kNearest = 32;
  // With room for the point, and for a vector more.
  static constexpr size_t kRoom = kNearest + 1 + size_t{2} * SpatialIndex::kLeafSize;

  SearchScratch search;
  GroupPoints points;
  alignas(64) int32_t places[kRoom];

  size_t bytes() const override { return sizeof(*this) + search.bytes(); }
  uint64_t work() const override { return search.work; }
};

// What was found around a point of the group.
struct NearestPoints {
  size_t i;                         // the point, in scratch.points
  std::span<const int32_t> places;  // of the nearest points in the tree order, the point itself among them
  float squared_radius;             // of the farthest, in the index's unit
};

// Calls `visit` for the points of the group that get a result, from scratch.first_point on, with their kNearest nearest
// neighbors, or all others of a small cloud. Errors as those of GroupPhase::run. Thread-safe for distinct scratch.
absl::Status ForEachNearest(const SpatialIndex& index, size_t group, NearestScratch& scratch,
                            absl::FunctionRef<void(const NearestPoints& found)> visit);

}  // namespace curvd
