// Tells of each point how its estimate was chosen, and how sure it is.
#pragma once

#include <cstddef>
#include <vector>

#include "core/estimators/options.h"
#include "core/estimators/point_choice.h"
#include "core/index/spatial_index.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/errors/standard_errors.h"
#include "core/scale/parts/cloud_choice.h"
#include "core/scale/parts/cloud_weights.h"

namespace curvd {

// Writes the choices of points whose results are written. Thread-safe for distinct groups and scratch.
class ChoiceWriter {
 public:
  // Everything outlives the object. Models the errors by what `choice` says now.
  ChoiceWriter(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
               const PointCurvature* results, PointChoice* choices);

  // Looks at the sampled points around those of a group, before any of them is written.
  void Start(AutomaticScratch& s) const;
  // Of a point of them, whose averages s holds.
  void Write(size_t point, AutomaticScratch& s) const { Write(point, true, s); }
  // The same of one at which some estimates are left out, because they reach across a seam.
  void WriteMended(size_t point, AutomaticScratch& s) const;

  size_t bytes() const;

 private:
  void Write(size_t point, bool has_errors, AutomaticScratch& s) const;
  void KeepSteady(CloudWeights::Weights& shares) const;
  void SetWeights(const CloudWeights::Weights& shares, PointChoice& choice) const;
  float ToCaller(double curvature) const;

  const EstimatorOptions& options_;
  const SpatialIndex& index_;
  const CloudChoice& choice_;
  const PointCurvature* const results_;
  PointChoice* const choices_;
  std::vector<ErrorModel> errors_;  // of each part
};

}  // namespace curvd
