// Estimates points by fits of their own, where what is chosen for a cloud does not serve them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/parts/cloud_choice.h"

namespace curvd {

// A point is fitted by the normals of its neighbors (EstimateDetail) where independent noise of these decides, and by
// their heights (EstimateByHeights); the fit with the smaller error counts. No neighbor lies beyond an edge. Writes
// results, and s.own_fits. Thread-safe for distinct groups and scratch.
class OwnFits {
 public:
  // Everything outlives the object.
  OwnFits(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
          PointCurvature* results);

  // Fits those points of a group that s.has_detail marks, and those whose average looks twice as far as a sphere of its
  // largest curvature is wide: around a thin pipe that can be right, but where one end of a body is sampled too thinly
  // for what is chosen, fewer neighbors serve it better. Of up to 256 neighbors, or of those of the rung above the
  // part's check for detail, and of as many as the options allow. Keeps the fits that differ from the averages by more
  // than their errors, and by much from those that look too far, and those of points that have none. Points that are
  // estimated from one side of an edge keep that. Errors as those of GroupPhase::run.
  absl::Status EstimateDetails(size_t group, AutomaticScratch& s) const;

  // Fits those points of a group for which is_asked(i) is true, of the neighbors within the largest of the scales for
  // which reaches(i, radius), in the caller's unit, is false, whatever their results are. Errors as those of
  // GroupPhase::run.
  absl::Status EstimateWithin(size_t group, absl::FunctionRef<bool(size_t i)> is_asked,
                              absl::FunctionRef<bool(size_t i, float radius)> reaches, AutomaticScratch& s) const;

 private:
  // Collects the neighbors of those points and calls fit(place, i) for each.
  absl::Status ForEach(size_t group, absl::FunctionRef<bool(size_t i)> is_asked,
                       absl::FunctionRef<void(size_t place, size_t i)> fit, AutomaticScratch& s) const;
  // Of the neighbors that were collected last, in the index's unit. Keeps what differs from `mean`, if there is one,
  // and else what has a small error. Of detail, neighbors on the far side of a body are left out of heights, and an
  // error that is small beside the curvature will do.
  std::optional<PointFit> Fit(size_t place, size_t i, std::span<const NeighborNormal> neighbors,
                              std::optional<double> mean, bool is_detail, const AutomaticScratch& s) const;
  void Take(size_t i, const std::optional<PointFit>& fit, AutomaticScratch& s) const;
  double ToCaller() const;

  const EstimatorOptions& options_;
  const SpatialIndex& index_;
  PointCurvature* const results_;
  const bool may_fit_normals_, may_fit_heights_;                   // the estimator is not fixed to another
  std::array<NeighborhoodPlan, CloudChoice::kMostParts> plans_{};  // of each part
  std::array<double, CloudChoice::kMostParts> noise_{};            // of positions, in the index's unit
  std::array<bool, CloudChoice::kMostParts> is_noise_{};           // independent noise of normals decides in the part
};

}  // namespace curvd
