// A plain double implementation of search and estimators: the oracle for the kernels. Written for clarity, one point at
// a time, from the papers' definitions and docs/numerics.md; shares nothing with core/kernels.
#pragma once

#include <cstddef>
#include <vector>

#include "core/estimators/options.h"
#include "tests/core/reference_measures.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

// Ids of the K nearest points of point i, itself included, ties to the lower id. Distances in double.
std::vector<int> NearestIds(const TestPoints& points, size_t i, size_t k);
// Ids of the points at distance <= radius of point i.
std::vector<int> IdsWithin(const TestPoints& points, size_t i, double radius);

// REQUIRES: options.estimator is avg-hexagram, hexagram, jet, aso or normal-regression.
ReferenceCurvature ReferenceEstimate(const TestPoints& points, size_t i, const EstimatorOptions& options);

}  // namespace curvd::testing
