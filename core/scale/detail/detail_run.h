// Estimates points at which what is chosen for a cloud smooths detail away.
#pragma once

#include <array>
#include <cstddef>

#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/parts/cloud_choice.h"

namespace curvd {

// Thread-safe for distinct groups and scratch.
class DetailRun {
 public:
  // Everything outlives the object.
  DetailRun(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
            PointCurvature* results);

  // Estimates those points of a group that s.has_detail marks by EstimateDetail, of no more neighbors than the rung
  // above the check has. Writes their results, and s.own_fits, where these differ from the averages. Errors as those of
  // GroupPhase::run.
  absl::Status Estimate(size_t group, AutomaticScratch& s) const;

 private:
  void EstimatePoint(size_t place, size_t point, AutomaticScratch& s) const;

  const EstimatorOptions& options_;
  const SpatialIndex& index_;
  PointCurvature* const results_;
  std::array<NeighborhoodPlan, CloudChoice::kMostParts> plans_{};  // of the rung above each part's check
};

}  // namespace curvd
