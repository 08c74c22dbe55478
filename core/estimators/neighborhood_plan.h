// Which neighborhood an estimate looks at, and how its size becomes the scale of what is estimated.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/search/search_plan.h"

namespace curvd {

// Derived once a run from the options and the index; the same for all groups.
struct NeighborhoodPlan {
  SearchPlan search;
  size_t least_count;   // a point with fewer neighbors has POINT_STATUS_TOO_FEW_NEIGHBORS
  float radius_factor;  // reported radius over the searched neighborhood's
  float rho_factor;     // radius of the figure over the searched neighborhood's
  float average_normal_weight;
  double radius;     // by radius: in the caller's unit, as reported
  double scale;      // the caller's length unit in index units: a power of two
  float half_scale;  // times other_half_scale: scale, which may be no float
  float other_half_scale;

  // By count, the search looks for `most_searched` neighbors at most; where that is fewer than the options ask for, the
  // radius is that of an even surface.
  // REQUIRES: options.Validate() is OK, and the neighborhood is not automatic; by count, the index holds as many points
  // as are asked for.
  static NeighborhoodPlan Make(const EstimatorOptions& options, const SpatialIndex& index,
                               size_t most_searched = ~size_t{0});
};

// The search that Make plans, save for the radius: what the size of buffers depends on. An automatic scale may come to
// its largest count.
SearchPlan SearchSizes(const EstimatorOptions& options, size_t most_searched = ~size_t{0});

// Most points that the search which SearchSizes describes may find, in an index of `point_count` points.
size_t MostNeighbors(const EstimatorOptions& options, size_t point_count);

// The error of a group whose scratch was stopped.
absl::Status Stopped();

// The error of a run whose radius gives the point at this place of the input more than plan.search.max_neighbor_count
// neighbors.
absl::Status NeighborhoodTooLarge(const NeighborhoodPlan& plan, size_t point);

}  // namespace curvd
