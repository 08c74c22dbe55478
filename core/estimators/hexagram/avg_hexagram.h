// What the averages over sectors derive from their options, and keep for each worker.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/hexagram/hexagram.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/rows/point_rows.h"

namespace curvd {

// The bounds of the sectors of all hexagrams are lines through the point, one of which is vertical; how many pairs of
// the others have opposed slopes. One that is left over is level.
constexpr int BoundPairs(int rotations) { return (3 * rotations - 1) / 2; }

struct AvgHexagramPlan {
  AvgHexagramPlan(const EstimatorOptions& options, const SpatialIndex& index);

  NeighborhoodPlan neighborhood;
  int rotations;                               // hexagrams a point
  float cotangent[BoundPairs(kMaxRotations)];  // of the angle between each pair of bounds and the axis u
};

struct AvgHexagramScratch : MeasuringScratch {
  Hexagram hexagrams[kMaxRotations];  // of each point of the group, the first `rotations` of them
  PointRows rows;                     // of leaves of the list that was searched last
  ScratchArray<int32_t> steps;        // neighbors of the point of the moment, and where they lie

  void Fill(size_t i) {
    for (Hexagram& hexagram : hexagrams) hexagram.Fill(i);
    measures.Fill(i);
  }
  size_t bytes() const override { return sizeof(*this) + search.bytes() + rows.bytes() + steps.bytes(); }
  // At one scale.
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count);
};

}  // namespace curvd
