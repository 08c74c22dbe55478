// What the strategies of random triangles derive from their options, and keep for each worker.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/rows/point_rows.h"
#include "core/estimators/triangles/rank_numbers.h"

namespace curvd {

struct TrianglePlan {
  TrianglePlan(const EstimatorOptions& options, const SpatialIndex& index)
      : neighborhood(NeighborhoodPlan::Make(options, index)),
        triangle_count(options.triangle_count),
        seed(options.seed) {}

  NeighborhoodPlan neighborhood;
  uint32_t triangle_count;
  uint64_t seed;
};

struct TriangleScratch : MeasuringScratch {
  // Elements that follow the last key, and the last of the order.
  static constexpr size_t kKeyPad = size_t{4} * SpatialIndex::kLeafSize;
  static constexpr size_t kOrderPad = size_t{3} * SpatialIndex::kLeafSize;

  PointRows rows;                 // of leaves of the list that was searched last
  RankNumbers numbers;            // of the points of that list, once a neighborhood asks for them
  ScratchArray<int32_t> keys;     // of the neighbors of the point of the moment: their ranks, or their numbers
  ScratchArray<uint32_t> listed;  // where their rows begin
  ScratchArray<uint32_t> order;   // the same in the order of their ranks

  size_t bytes() const override {
    return sizeof(*this) + search.bytes() + rows.bytes() + numbers.bytes() + keys.bytes() + listed.bytes() +
           order.bytes();
  }
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count) {
    const size_t neighbors = MostNeighbors(options, point_count);
    const size_t leaves = MostFoundLeaves(SearchSizes(options), point_count);
    return sizeof(TriangleScratch) + SearchScratchBytes(SearchSizes(options), point_count) +
           PointRows::MostBytes(leaves) + RankNumbers::MostBytes(leaves) +
           2 * ScratchArray<uint32_t>::MostBytes(neighbors + kKeyPad) +
           ScratchArray<uint32_t>::MostBytes(neighbors + kOrderPad);
  }
};

}  // namespace curvd
