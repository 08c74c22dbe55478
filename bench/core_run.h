// One estimate by the core, and what it cost.
#pragma once

#include "bench/clouds.h"
#include "bench/side_by_side.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/job/worker_pool.h"

namespace curvd::bench {

// Estimates the whole cloud on `pool`: from the cloud in memory to the field. Ends the program on failure.
// Figures, in CPU seconds of the process: total, build (the index), query (search, umbrellas and estimate), and in
// wall-clock seconds: wall. `field` gets the result unless it is null.
Figures RunCore(const BenchCloud& cloud, const EstimatorOptions& options, WorkerPool& pool,
                CurvatureField* field = nullptr);

// Options for `k` neighbors.
EstimatorOptions OptionsFor(std::string_view estimator, uint32_t k, uint32_t rotations = 1);

}  // namespace curvd::bench
