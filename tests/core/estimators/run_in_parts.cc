#include "tests/core/estimators/run_in_parts.h"

#include <gtest/gtest.h>

#include <memory>

namespace curvd::testing {

void RunInParts(StrategyRun& run, const SpatialIndex& index, WorkerScratch& scratch) {
  for (const GroupPhase& phase : run.Phases()) {
    const absl::StatusOr<bool> is_needed = phase.Begin();
    ASSERT_TRUE(is_needed.ok()) << is_needed.status();
    if (!*is_needed) continue;
    for (size_t group = 0; group < index.group_count(); ++group) {
      scratch.first_point = 0;
      do {
        scratch.rest = 0;
        ASSERT_TRUE(phase.run(group, scratch).ok());
        scratch.first_point = scratch.rest;
      } while (scratch.rest > 0);
    }
  }
}

void RunInParts(StrategyRun& run, const SpatialIndex& index, uint64_t most_work) {
  const std::unique_ptr<WorkerScratch> scratch = run.MakeScratch();
  scratch->most_work = most_work;
  RunInParts(run, index, *scratch);
}

}  // namespace curvd::testing
