// Averages once more, where chosen estimates reach across a seam, those that do not.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/estimators/seams/seam_reach.h"
#include "core/index/spatial_index.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/chosen/choice_writer.h"
#include "core/scale/chosen/chosen_estimates.h"
#include "core/scale/detail/own_fits.h"

namespace curvd {

// For a cloud that shows a seam, once every result is written. Thread-safe for distinct groups and scratch.
class SeamMending {
 public:
  // Everything outlives the object. `own_fits`: null where no point is estimated in its own way. `choices`: null where
  // nobody asks how points were chosen.
  SeamMending(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks,
              const ChosenEstimates& estimates, const OwnFits* own_fits, const ChoiceWriter* choices,
              PointCurvature* results)
      : reach_(options, index, marks),
        estimates_(estimates),
        own_fits_(own_fits),
        choices_(choices),
        results_(results) {}

  // Averages anew the results of a group, from s.first_point on, that reach across a seam. Those for which no estimate
  // is left get a fit of their own, of neighbors short of the seam, or stay as they are, and are refused by whoever
  // looks at seams. Errors as those of GroupPhase::run.
  absl::Status Mend(size_t group, AutomaticScratch& s) const;

 private:
  struct Points;

  bool Reaches(size_t i, float radius, const AutomaticScratch& s) const;
  void AddShortOfSeams(size_t i, size_t estimate, Points& at, AutomaticScratch& s) const;
  absl::Status Finish(size_t group, const Points& at, AutomaticScratch& s) const;

  const SeamReach reach_;
  const ChosenEstimates& estimates_;
  const OwnFits* const own_fits_;
  const ChoiceWriter* const choices_;
  PointCurvature* const results_;
};

}  // namespace curvd
