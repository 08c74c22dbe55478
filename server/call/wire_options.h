// The options of core/estimators/option_specs.h in curvature.v1.EstimatorOptions, where each is the field of its name.
#pragma once

#include "absl/status/status.h"
#include "core/estimators/options.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {

// Takes every option that `proto` sets; one that it leaves out, or for numbers without presence gives as 0, keeps its
// default. Errors: INVALID_ARGUMENT with its ErrorDetail, an option is out of its range.
absl::Status ReadOptions(const curvature::v1::EstimatorOptions& proto, EstimatorOptions& options);

// Writes every option.
void WriteOptions(const EstimatorOptions& options, curvature::v1::EstimatorOptions& proto);

}  // namespace curvd
