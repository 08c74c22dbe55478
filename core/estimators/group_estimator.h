// Estimates curvature at the points of one group of leaves: the core's inner loop, compiled for each instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/estimators/curvature_field.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"

namespace curvd {

// What the kernels need to know, derived once a job from the options and the index.
struct EstimationPlan {
  EstimatorKind estimator;
  bool by_radius;
  size_t neighbor_count;  // by count: points in a neighborhood
  size_t searched_count;  // by count: points that the search looks for; at most neighbor_count
  float radius_factor;    // reported radius over the searched neighborhood's
  float rho_factor;       // radius of the figure over the searched neighborhood's
  float squared_radius;   // by radius: in the index's unit
  double radius;          // by radius: in the caller's unit
  size_t max_neighbor_count;
  float average_normal_weight;
  int rotations;                // hexagrams a point, for averages
  float cosine[kMaxRotations];  // of the angle that each is turned by
  float sine[kMaxRotations];
  uint32_t triangle_count;
  uint64_t seed;
  int jet_degree;
  const Umbrella* umbrellas;  // Delaunay: of all points, by slot, occurrences counted
  float falloff;              // Delaunay: weight that a corner loses from the point to the neighborhood's rim
  float spread;               // Delaunay: mean square distance of the weighted triangles along an axis, over rho^2
  double scale;               // the caller's length unit in index units: a power of two
  float half_scale;           // times other_half_scale: scale
  float other_half_scale;

  // `umbrellas` is left for the caller to set.
  // REQUIRES: options.Validate() is OK.
  static EstimationPlan Make(const EstimatorOptions& options, const SpatialIndex& index);
  // For BuildUmbrellas.
  static EstimationPlan ForUmbrellas(const SpatialIndex& index);
};

// A radius neighborhood larger than the plan allows.
struct OversizedNeighborhood {
  int32_t point_id = -1;  // -1: there is none
};

// Buffers of one thread. What they hold between calls only seeds searches; results never depend on it.
class GroupScratch {
 public:
  GroupScratch();
  ~GroupScratch();
  GroupScratch(GroupScratch&&) noexcept;

  // How many points ended in each status, since the scratch was made.
  const std::array<uint64_t, kPointStatusEnd>& status_counts() const;

  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

// Sets the rims of the umbrellas of group `group`; `umbrellas` holds those of the whole cloud, by slot.
// Thread-safe for distinct scratch and groups.
void BuildUmbrellas(const SpatialIndex& index, const EstimationPlan& plan, size_t group, GroupScratch& scratch,
                    Umbrella* umbrellas);

// Writes out[id] for each point of group `group`; `out` is the field of the whole cloud. Stops at the first
// neighborhood above plan.max_neighbor_count.
// Thread-safe for distinct scratch.
OversizedNeighborhood EstimateGroup(const SpatialIndex& index, const EstimationPlan& plan, size_t group,
                                    GroupScratch& scratch, PointCurvature* out);

}  // namespace curvd
