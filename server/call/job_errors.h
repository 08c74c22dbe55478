// What callers learn of a job that failed.
#pragma once

#include "absl/status/status.h"

namespace curvd {

// An error of an EstimationJob with the reason that callers see. REQUIRES: !status.ok().
absl::Status ExplainJobError(absl::Status status);

}  // namespace curvd
