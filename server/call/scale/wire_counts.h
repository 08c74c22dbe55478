// Several numbers of neighbors on the wire.
#pragma once

#include "absl/status/status.h"
#include "core/estimators/options.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/request_limits.h"

namespace curvd {

// Sets the neighborhood of `options`, and the smaller counts beside it, to proto.neighbor_counts. Errors, each with its
// ErrorDetail:
// - INVALID_ARGUMENT: there are too many, they do not ascend, one is out of its range, another neighborhood is set as
//   well, or there are several for an estimator that takes one.
// - RESOURCE_EXHAUSTED: a count is over the limit of this server.
// REQUIRES: there are some; the estimator of `options` is known.
absl::Status ReadCounts(const curvature::v1::EstimatorOptions& proto, const CallLimits& limits,
                        EstimatorOptions& options);

// The answer to that. REQUIRES: the neighborhood is by count.
void WriteCounts(const EstimatorOptions& options, curvature::v1::EstimatorOptions& proto);

}  // namespace curvd
