// Quantities that say how an estimate was chosen, and how sure it is.
#pragma once

#include "absl/status/status.h"
#include "core/estimators/options.h"
#include "server/call/quantity_set.h"

namespace curvd {

// Has `options` return choices where `quantities` need them. INVALID_ARGUMENT, with its ErrorDetail, where the estimate
// is none of which they can be told. REQUIRES: `options` are valid.
absl::Status ResolveChoice(const QuantitySet& quantities, EstimatorOptions& options);

}  // namespace curvd
