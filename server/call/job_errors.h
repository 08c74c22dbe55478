// What callers learn of a cloud that was refused and of a job that failed.
#pragma once

#include "absl/status/status.h"

namespace curvd {

// Returns an error of an EstimationJob with the reason that callers see, by its kind (core/base/error.h); one of an
// unexpected kind is INTERNAL. `radius_field` is the radius that was in use last. REQUIRES: !status.ok().
absl::Status ExplainJobError(absl::Status status, const char* radius_field = "header.options.radius");

// The same for an error of a Cloud that takes points, whose messages already name point and value.
// REQUIRES: !status.ok().
absl::Status ExplainCloudError(absl::Status status);

// The same for an error of kind kOutOfMemory, wherever it comes from.
absl::Status ExplainOutOfMemory(absl::Status status);

}  // namespace curvd
