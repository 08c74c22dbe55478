// Keeps estimates from reaching over sharp edges: finds the edges of a cloud, and estimates points beside them from
// their own side (docs/numerics/automatic_choice.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/scale/edges/edge_marks.h"
#include "core/scale/edges/normal_trend.h"
#include "core/scale/edges/one_side.h"
#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// What the choice of scales says of one point beside an edge.
struct OneSideScale {
  size_t count;          // of neighbors
  double allowed_error;  // of the mean curvature, in 1 / the index's length
  uint32_t least_count;  // of neighbors whose heights are fitted
};

// Usage: Measure every group; Sample; Mark every group; Finish; KeepClear; then ask; LookAmong; Repair points of any
// group. Measure, Mark and Repair are thread-safe for distinct groups and scratch.
class EdgeRun {
 public:
  // REQUIRES: `index` has normals, and outlives the object. May throw std::bad_alloc.
  explicit EdgeRun(const SpatialIndex& index);

  // How rough normals are around a quarter of the points. Errors as those of GroupPhase::run.
  absl::Status Measure(size_t group, PilotScratch& scratch);
  // Looks at the roughness of some points: what is usual in a place is noise. That of the positions has this standard
  // deviation, in the index's unit.
  void Sample(double position_noise);
  // Finds out whether points lie beside an edge: of groups that may have such points, by the others too. Errors as
  // those of GroupPhase::run, but that no part of the group is left to another run.
  absl::Status Mark(size_t group, PilotScratch& scratch);
  void Finish();
  // Takes the scales that reach over an edge away from the points of `table`.
  void KeepClear(PilotTable& table) const;

  bool HasEdges() const;
  // From a position to the nearest point beside an edge, in the index's unit; infinity where there is no edge.
  float DistanceToEdge(const float* position) const;
  // Repair looks among so many neighbors, a third of the cloud at most, for those on the side of a point.
  void LookAmong(uint32_t count);
  // Estimates points of a group from their own sides: of those that get a result, from scratch.first_point on, each for
  // which is_one_sided(i) is true; take(n, estimate) is called for the n-th of those, from 0 on, if it has one, of
  // lengths in the caller's unit. `scale_at(position)` is asked at each; no neighbor is farther than `most_radius`, in
  // the index's unit. Errors as those of GroupPhase::run.
  absl::Status Repair(size_t group, float most_radius, absl::FunctionRef<bool(size_t i)> is_one_sided,
                      absl::FunctionRef<OneSideScale(const float* position)> scale_at,
                      absl::FunctionRef<void(size_t n, const PointFit& estimate)> take, PilotScratch& scratch) const;

  size_t bytes() const { return marks_.bytes() + samples_.capacity() * sizeof(Sampled); }

 private:
  // Measures those of the group's points, from scratch.first_point on, for which `keep` is true.
  absl::Status MeasureTrends(size_t group, absl::FunctionRef<bool(size_t place)> keep, PilotScratch& scratch);

  struct Sampled {
    std::array<float, 3> position;
    float roughness;
  };

  // The noise of normals along each tangent that is usual around a group.
  double NoiseAround(size_t group) const;

  const SpatialIndex& index_;
  const bool is_large_enough_;
  NeighborhoodPlan measured_{}, repaired_{};
  EdgeMarks marks_;
  std::vector<Sampled> samples_;
  double position_noise_ = 0.0;
};

}  // namespace curvd
