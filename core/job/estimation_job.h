// One cloud's way through the core: index, neighborhoods, estimates, field.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/options.h"
#include "core/job/worker_pool.h"

namespace curvd {

enum class JobPhase : uint8_t { kQueued, kIndexing, kEstimating, kDone };

// What a job may be asked while it runs, and afterwards.
struct JobProgress {
  JobPhase phase = JobPhase::kQueued;
  size_t points_estimated = 0;
  // Wall-clock seconds of the phases that it came to; of the last one until now, or until the job's end.
  double queue_seconds = 0.0;
  std::optional<double> index_seconds;
  std::optional<double> estimate_seconds;
};

// What a job cost, complete once its callback is called.
struct JobCost {
  double queue_seconds = 0.0;  // from Start to the first work block
  double index_seconds = 0.0;
  double estimate_seconds = 0.0;
  double umbrella_seconds = 0.0;  // of the estimate: Delaunay only
  size_t peak_bytes = 0;          // cloud, index, umbrellas and field together
};

struct EstimationResult {
  CurvatureField field;
  JobCost cost;
};

// Bytes that estimating one point needs at the peak, cloud and field included: what admission should reserve.
constexpr size_t EstimationBytesPerPoint(EstimatorKind estimator) {
  return 96 + (estimator == EstimatorKind::kDelaunay ? sizeof(Umbrella) : 0);
}

// Thread-safe.
class EstimationJob {
 public:
  // Called once on a worker thread (or before Start returns, if options are invalid or there is no memory). Errors:
  // - INVALID_ARGUMENT: options.Validate() failed.
  // - RESOURCE_EXHAUSTED: a radius neighborhood exceeds max_neighbor_count, or no memory.
  // - CANCELLED: Cancel was called.
  using Callback = std::function<void(absl::StatusOr<EstimationResult>)>;

  // Estimates `cloud` on `pool`, which must outlive the callback. The same cloud and options give the same bytes for
  // any number of threads. A cloud without points gives an empty field.
  // `caller`: for whom, as WorkerPool::Submit takes it.
  // REQUIRES: cloud.Finish() was called.
  static std::shared_ptr<EstimationJob> Start(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool,
                                              JobPriority priority, Callback callback, CallerKey caller = 0);

  virtual ~EstimationJob() = default;
  // Makes the job end with CANCELLED within one work block. No effect after its end.
  virtual void Cancel() = 0;
  virtual JobProgress progress() const = 0;
};

// Runs a job and waits for it. REQUIRES: not called on a thread of `pool`.
absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool);

}  // namespace curvd
