// One cloud's way through the core: index, normals, neighborhoods, estimates, field.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/point_choice.h"
#include "core/estimators/seams/normals_agreement.h"
#include "core/job/phased_job.h"
#include "core/job/worker_pool.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "core/normals/trust/surface_probe.h"
#include "core/scale/scale_report.h"

namespace curvd {

enum class JobPhase : uint8_t { kQueued, kIndexing, kMakingNormals, kOrienting, kEstimating, kDone };

// Wall-clock seconds of the phases that a job came to; of the last one until now, or until the job's end.
struct JobSeconds {
  double queue = 0.0;  // from Start to the first work block
  std::optional<double> index;
  std::optional<double> normals;      // making them of the positions
  std::optional<double> orientation;  // turning them to one side, and handing them out
  std::optional<double> estimate;     // all phases of curvature
};

// What a job may be asked while it runs, and afterwards.
struct JobProgress {
  JobPhase phase = JobPhase::kQueued;  // normals may be made, and oriented, several times in turns
  size_t points_estimated = 0;         // those that get a result; of the work blocks that have ended
  JobSeconds seconds;
};

// What a job cost, complete once its callback is called.
struct JobCost {
  JobSeconds seconds;
  std::vector<PhaseTime> phases;  // the same time by phase (SecondsOf)
  size_t peak_bytes = 0;          // of large arrays: cloud, index, field, and what is made of them on the way
};

struct EstimationResult {
  CurvatureField field;  // of the largest scale; the counts are over all scales
  NormalsAgreement agreement;
  JobCost cost;
  std::optional<NormalsOffSurface> off_surface = std::nullopt;  // of normals that came with the cloud, if it tells
  std::optional<NormalReport> normal_report = std::nullopt;     // unless normals were taken as they came
  NormalField normals = {};                                     // the ones in use, if NormalOptions::returns_normals
  std::optional<ScaleReport> scale_report = std::nullopt;       // of an automatic estimate, or one with choices
  ChoiceField choices = {};                                     // if EstimatorOptions::returns_choice
  // At each of EstimatorOptions::smaller_counts: what an estimate at that scale alone gives, to the byte.
  std::vector<PageArray<PointCurvature>> smaller = {};
};

// Thread-safe.
class EstimationJob {
 public:
  // Called once on a worker thread (or before Start returns, if options are invalid or there is no memory). Must not
  // throw. Errors are told apart by KindOf (core/base/error.h):
  // - kInvalid: options.Validate() failed; or the cloud has no normals, none were to be estimated, and they were to be
  //   oriented, or options.estimator needs them.
  // - kRepeatedId: two points have the same id.
  // - kOpposedNormals: normals point to opposite sides of one surface, and options.opposed_normals is kReject.
  // - kNeighborhoodTooLarge: a radius neighborhood exceeds max_neighbor_count.
  // - kOutOfMemory: the system gave no memory, on whatever thread.
  // - kCancelled: Cancel was called in time.
  using Callback = std::function<void(absl::StatusOr<EstimationResult>)>;

  // Estimates `cloud` on `pool`, which must outlive the callback. The same cloud and options give the same bytes for
  // any number of threads. A cloud without points gives an empty field.
  // `caller`: for whom, as WorkerPool::Submit takes it.
  // Throws nothing, and never returns null: whatever goes wrong, the callback gets it.
  // REQUIRES: cloud.Finish() was called.
  static std::shared_ptr<EstimationJob> Start(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool,
                                              JobPriority priority, Callback callback, CallerKey caller = 0);
  // The same with normals that are first made, or oriented, as `normals` says. A point for which no normal can be
  // estimated has no curvature; its status is that of PointNormal. Points whose estimate uses its normal have none
  // either (docs/numerics/normals.md). REQUIRES: what `normals` refers to lives until the callback is called.
  static std::shared_ptr<EstimationJob> Start(Cloud cloud, const EstimatorOptions& options,
                                              const NormalOptions& normals, WorkerPool& pool, JobPriority priority,
                                              Callback callback, CallerKey caller = 0);

  // The same without curvature: makes normals as `normals` says, and hands them out whatever normals.returns_normals
  // says. The field has no points, and its counts are those of the normals.
  static std::shared_ptr<EstimationJob> StartNormals(Cloud cloud, const NormalOptions& normals, WorkerPool& pool,
                                                     JobPriority priority, Callback callback, CallerKey caller = 0);

  virtual ~EstimationJob() = default;
  // Asks the job to end with kCancelled; returns at once. No other work block of the job begins. Those that run end
  // early: an estimate after the point at hand, a split of the index within tens of milliseconds. The
  // callback is called when they are over and the pool has come to the job's next turn, before which blocks of others
  // may run. No effect once the last block has ended, nor on the error of a job that has failed: the callback then gets
  // the result, or that error. Allocates nothing.
  virtual void Cancel() = 0;
  // Allocates nothing.
  virtual JobProgress progress() const = 0;
};

// Runs a job and waits for it. REQUIRES: not called on a thread of `pool`.
absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool);
absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options,
                                                   const NormalOptions& normals, WorkerPool& pool);

}  // namespace curvd
