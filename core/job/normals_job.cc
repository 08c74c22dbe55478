#include "core/job/normals_job.h"

#include <latch>
#include <utility>

namespace curvd {

absl::StatusOr<NormalResult> MakeNormals(Cloud cloud, const NormalOptions& options, WorkerPool& pool) {
  absl::StatusOr<EstimationResult> result;
  std::latch done(1);
  EstimationJob::StartNormals(std::move(cloud), options, pool, JobPriority::kBatch, [&](auto made) {
    result = std::move(made);
    done.count_down();
  });
  done.wait();
  if (!result.ok()) return result.status();
  NormalReport report = result->normal_report.value_or(NormalReport());
  report.status_counts = result->field.status_counts;
  return NormalResult{std::move(result->normals), report, std::move(result->cost)};
}

}  // namespace curvd
