// Runs of normal-regression in degree 1: linear regression of the normals over space (docs/numerics.md).
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/estimators/strategy.h"

namespace curvd {

// As Strategy::scratch_bytes, Strategy::start and Strategy::start_scales.
size_t LinearRegressionBytes(const EstimatorOptions& options, size_t point_count);
std::unique_ptr<StrategyRun> StartLinearRegression(const EstimatorOptions& options, const SpatialIndex& index,
                                                   PointCurvature* results);
std::unique_ptr<StrategyRun> StartLinearRegressionScales(const EstimatorOptions& options, const SpatialIndex& index,
                                                         std::span<PointCurvature* const> results);

}  // namespace curvd
