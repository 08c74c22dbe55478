// One pass over a cloud: index, normals, neighborhoods, estimates, field; and what is left of the cloud if the estimate
// shows outliers.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "core/cloud/cloud.h"
#include "core/estimators/options.h"
#include "core/job/estimation_job.h"
#include "core/job/phases/outlier_phases.h"
#include "core/job/worker_pool.h"
#include "core/normals/normal_options.h"
#include "core/scale/outliers/outlier_run.h"

namespace curvd {

// For whom a job runs, and where.
struct JobPlace {
  WorkerPool& pool;
  JobPriority priority;
  CallerKey caller;
};

// As EstimationJob says, but for outliers. Thread-safe, save for TakeRest.
class CurvatureJob : public EstimationJob {
 public:
  // `origin` is what was subtracted from the positions of the cloud that the caller knows, which may be another one.
  // Without `options`, no curvature is estimated. Unless `search` is kNone, the job may end with a
  // rest in place of a result. May throw std::bad_alloc.
  static std::shared_ptr<CurvatureJob> Make(Cloud cloud, const std::array<double, 3>& origin,
                                            const std::optional<EstimatorOptions>& options,
                                            const NormalOptions& normals, const JobPlace& place, OutlierSearch search);

  // From here on `callback` will be called, whatever happens. REQUIRES: called once.
  virtual void Start(Callback callback) = 0;

  // The cloud without its outliers, if there are any: the result has then no points, but for its cost. REQUIRES: called
  // by the callback.
  virtual std::optional<OutlierPhases::Rest> TakeRest() = 0;
};

}  // namespace curvd
