// Automatic scales on the wire: what a header asks for, and what a summary tells of them.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "core/estimators/options.h"
#include "core/scale/scale_report.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/request_limits.h"

namespace curvd {

// Sets the neighborhood of `options` to what `proto` asks for, and the degree of jets to the one that the choice knows.
// Errors, each with its ErrorDetail:
// - INVALID_ARGUMENT: a field is out of its range.
// - RESOURCE_EXHAUSTED: a count is over the limit of this server.
absl::Status ReadScale(const curvature::v1::AutomaticScale& proto, const CallLimits& limits, EstimatorOptions& options);

// INVALID_ARGUMENT, with its ErrorDetail, where the choice knows nothing of the estimator, of its degree, or of the
// neighborhood. REQUIRES: options.is_automatic(), and its other fields are in their ranges.
absl::Status CheckChoice(const EstimatorOptions& options);

// The same of an estimator that is not auto, `where` the choice has to know it. REQUIRES: as above, and the estimator
// is one of core/estimators/strategies.h.
absl::Status CheckMethod(const EstimatorOptions& options, std::string_view where);

// The answer to what was asked for, with every default.
void WriteScale(const AutomaticScale& scale, curvature::v1::AutomaticScale& proto);

// What a summary tells of the choice.
void WriteReport(const ScaleReport& report, curvature::v1::ScaleReport& proto);

}  // namespace curvd
