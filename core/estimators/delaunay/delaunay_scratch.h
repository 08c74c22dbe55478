// What the strategy of Delaunay umbrellas derives from its options, and keeps for each worker.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/delaunay/umbrella_triangles.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/neighborhood_plan.h"

namespace curvd {

struct DelaunayPlan {
  DelaunayPlan(const EstimatorOptions& options, const SpatialIndex& index)
      : neighborhood(NeighborhoodPlan::Make(options, index)),
        falloff(options.even_weights ? 0.0f : 1.0f),
        spread(options.even_weights ? 0.0f : 1.0f / 6.0f) {}

  NeighborhoodPlan neighborhood;
  float falloff;                        // weight that a corner loses from the point to the neighborhood's rim
  float spread;                         // mean square distance of the weighted triangles along an axis, over rho^2
  const Umbrella* umbrellas = nullptr;  // of all points, by place in the tree order; occurrences counted
};

struct DelaunayScratch : MeasuringScratch {
  UmbrellaTriangles triangles;       // near the list that was searched last
  ScratchArray<uint32_t> positions;  // in that list, of the leaves with neighbors of the point of the moment

  size_t bytes() const override { return sizeof(*this) + search.bytes() + triangles.bytes() + positions.bytes(); }
};

}  // namespace curvd
