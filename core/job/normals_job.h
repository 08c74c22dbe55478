// Normals without curvature, for callers that wait.
#pragma once

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/job/estimation_job.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"

namespace curvd {

struct NormalResult {
  NormalField normals;
  NormalReport report;
  JobCost cost;
};

// Runs EstimationJob::StartNormals and waits for it. What was given is reported as such.
// REQUIRES: not called on a thread of `pool`.
absl::StatusOr<NormalResult> MakeNormals(Cloud cloud, const NormalOptions& options, WorkerPool& pool);

}  // namespace curvd
