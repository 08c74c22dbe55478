// Makes a message that shows how far a call is.
#pragma once

#include <cstdint>
#include <optional>

#include "core/job/estimation_job.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {

// `job` is how far the call's job is; none while the cloud is received.
void FillProgress(uint64_t points_received, const std::optional<JobProgress>& job, curvature::v1::Progress* progress);

}  // namespace curvd
