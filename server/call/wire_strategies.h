// What the core's strategies are called in curvature.v1.
#pragma once

#include "core/estimators/strategy.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {

// The value of curvature.v1.Estimator that stands for a strategy; ESTIMATOR_UNSPECIFIED if the contract has none.
curvature::v1::Estimator WireEstimator(const Strategy& strategy);

// The strategy that a value stands for, or nullptr if this server has none. ESTIMATOR_UNSPECIFIED stands for none.
const Strategy* StrategyOf(curvature::v1::Estimator estimator);

}  // namespace curvd
