// Runs the phases of an estimate on one thread, without a job.
#pragma once

#include <cstdint>

#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"

namespace curvd::testing {

// All phases of `run`, over all groups of `index`. No run of a group does more than `scratch.most_work`: what it
// leaves, the next does.
void RunInParts(StrategyRun& run, const SpatialIndex& index, WorkerScratch& scratch);
// The same with scratch of its own.
void RunInParts(StrategyRun& run, const SpatialIndex& index, uint64_t most_work);

}  // namespace curvd::testing
