#include "server/call/progress_message.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

v1::Progress::Phase PhaseOf(JobPhase phase) {
  switch (phase) {
    case JobPhase::kQueued:
      return v1::Progress::PHASE_QUEUED;
    case JobPhase::kIndexing:
      return v1::Progress::PHASE_INDEXING;
    case JobPhase::kMakingNormals:
      return v1::Progress::PHASE_ESTIMATING_NORMALS;
    case JobPhase::kOrienting:
      return v1::Progress::PHASE_ORIENTING;
    case JobPhase::kEstimating:
      return v1::Progress::PHASE_ESTIMATING;
    case JobPhase::kDone:
      return v1::Progress::PHASE_SENDING;
  }
  return v1::Progress::PHASE_SENDING;
}

}  // namespace

void FillProgress(uint64_t points_received, const std::optional<JobProgress>& job, v1::Progress* progress) {
  progress->set_phase(job.has_value() ? PhaseOf(job->phase) : v1::Progress::PHASE_RECEIVING);
  progress->set_points_received(points_received);
  progress->set_points_estimated(job.has_value() ? job->points_estimated : 0);
}

}  // namespace curvd
