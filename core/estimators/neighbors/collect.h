// Collects the neighbors of every point of a group, one point at a time.
//
// No Eigen here: after its headers, gcc 12 forgets -fmerge-all-constants, and kernels that come later in
// a unit copy Highway's tables of Compress to the stack at each use.
#pragma once

#include <cstddef>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/scratch_array.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/neighbors/neighbors.h"
#include "core/index/spatial_index.h"

namespace curvd {

// The neighbors are those of the point of the moment.
struct CollectScratch : GroupScratch {
  NeighborArrays neighbors;
  ScratchArray<int32_t> ids;  // of the neighbors

  size_t bytes() const override { return sizeof(*this) + search.bytes() + neighbors.bytes() + ids.bytes(); }
  // REQUIRES: the options are by count.
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count) {
    const size_t most = MostNeighbors(options, point_count);
    return sizeof(CollectScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
           NeighborArrays::MostBytes(most) + ScratchArray<int32_t>::MostBytes(most + NeighborArrays::kPad);
  }
};

// Which points of a group are looked at.
enum class CollectedPoints : uint8_t {
  kAll,      // those that get no result included
  kQueries,  // those that get one
};

// Which normals of the neighbors are collected.
enum class CollectedNormals : uint8_t {
  kInUse,
  kOfHalves,  // where the index has them; else those in use
};

// Loads the points of a group, from scratch.first_point on, keeps those of them, by their order, for which keep(i) is
// true, and calls visit(i) for each once scratch.neighbors and scratch.ids hold its neighbors; i is then its place in
// scratch.points. Errors as those of GroupPhase::run. REQUIRES: `plan` is by count; `index` has normals.
absl::Status CollectNeighbors(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                              CollectedPoints which, CollectedNormals normals, CollectScratch& scratch,
                              absl::FunctionRef<bool(size_t i)> keep, absl::FunctionRef<void(size_t i)> visit);

}  // namespace curvd
