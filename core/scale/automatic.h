// Estimates whose estimator or scale is chosen from the cloud.
#pragma once

#include "core/estimators/strategy.h"

namespace curvd {

// What estimates as `options` say: a row of core/estimators/strategies.h, or, where options.is_automatic() or
// options.returns_choice, one that samples the cloud, chooses, and averages what the chosen estimators find at each
// point. REQUIRES: options.Validate() is OK.
const Strategy& StrategyFor(const EstimatorOptions& options);

// Whether the estimate tells noise by halves of neighborhoods, and reads normals, so that it is to have normals of
// halves where they are estimated.
bool ComparesNormalsOfHalves(const EstimatorOptions& options);

// The fewest points that a cloud needs for an estimate of any point; 0 where a radius decides.
uint32_t LeastPoints(const EstimatorOptions& options);

}  // namespace curvd
