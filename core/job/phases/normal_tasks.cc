#include "core/job/phases/normal_tasks.h"

#include "core/scale/automatic.h"

namespace curvd {

NormalTasks TasksFor(const std::optional<EstimatorOptions>& estimate, const NormalOptions& normals) {
  if (!estimate.has_value()) return {.returns_normals = true};
  return {.returns_normals = normals.returns_normals,
          .makes_halves = ComparesNormalsOfHalves(*estimate),
          .makes_fits_anew = estimate->estimator == kAutomaticEstimator};
}

}  // namespace curvd
