// What each strategy does with the groups of an index, step by step.
#pragma once

#include <memory>
#include <vector>

#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/job/group_phase.h"

namespace curvd {

inline constexpr std::string_view kUmbrellaPhase = "umbrellas";
inline constexpr std::string_view kEstimatePhase = "estimate";

// What users call the strategy: "avg-hexagram".
const char* StrategyName(const EstimatorOptions& options);

// Bytes of large arrays that a strategy makes for each point, beside cloud, index and field.
size_t StrategyBytesPerPoint(const EstimatorOptions& options);

// The most bytes of scratch that one thread holds while it estimates a cloud of `point_count` points.
size_t ScratchBytesPerWorker(const EstimatorOptions& options, size_t point_count);

// A strategy at work on one index: its steps, and what they share.
class StrategyRun {
 public:
  // REQUIRES: options.Validate() is OK; `index` and `points` outlive the run.
  StrategyRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* points);

  // The steps in order; the last one is named kEstimatePhase and writes every point of the index. Errors:
  // - kNeighborhoodTooLarge: a radius gives a point more than options.max_neighbor_count neighbors.
  // - kOutOfMemory. REQUIRES: the run outlives them.
  std::vector<GroupPhase> phases();

  // Bytes of large arrays that it holds beside the index and the field.
  size_t bytes() const { return umbrellas_.bytes(); }
  const EstimationPlan& plan() const { return plan_; }

 private:
  absl::Status MakeUmbrellas();
  absl::Status Estimate(size_t group, GroupScratch& scratch) const;

  const EstimatorOptions options_;
  const SpatialIndex& index_;
  PointCurvature* points_;
  EstimationPlan plan_;
  EstimationPlan umbrella_plan_{};
  PageArray<Umbrella> umbrellas_;  // Delaunay only
};

}  // namespace curvd
