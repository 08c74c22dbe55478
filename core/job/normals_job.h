// One cloud's way to normals without curvature: index, normals, sides.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/job/estimation_job.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"

namespace curvd {

struct NormalResult {
  NormalField normals;
  NormalReport report;
  JobCost cost;  // estimate_seconds: of all phases after the index
};

// Thread-safe.
class NormalsJob {
 public:
  // Called once, as EstimationJob::Callback is. Errors, told apart by KindOf:
  // - kInvalid: options.Validate() failed, or normals are to be used that the cloud does not have.
  // - kNeighborhoodTooLarge, kOutOfMemory, kCancelled: as there.
  using Callback = std::function<void(absl::StatusOr<NormalResult>)>;

  // Makes normals of `cloud` on `pool`, which must outlive the callback, and hands them out whatever
  // options.returns_normals says. The same cloud and options give the same bytes for any number of threads. A cloud
  // without points gives an empty field.
  // Throws nothing, and never returns null: whatever goes wrong, the callback gets it.
  // REQUIRES: cloud.Finish() was called; what `options` refers to lives until the callback is called.
  static std::shared_ptr<NormalsJob> Start(Cloud cloud, const NormalOptions& options, WorkerPool& pool,
                                           JobPriority priority, Callback callback, CallerKey caller = 0);

  virtual ~NormalsJob() = default;
  // As EstimationJob::Cancel.
  virtual void Cancel() = 0;
};

// Runs a job and waits for it. REQUIRES: not called on a thread of `pool`.
absl::StatusOr<NormalResult> MakeNormals(Cloud cloud, const NormalOptions& options, WorkerPool& pool);

}  // namespace curvd
