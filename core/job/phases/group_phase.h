// A step of an estimate over the groups of an index, as a phase of a job.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/phase.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Scratch of each thread of a pool, made when the thread first needs it.
class ScratchSet {
 public:
  // Points beside a seam are marked in `seams`, if it is not null. REQUIRES: `run` and `seams` outlive the set.
  ScratchSet(const StrategyRun& run, int thread_count, SeamMarks* seams = nullptr)
      : run_(run), seams_(seams), scratch_(thread_count) {}
  // REQUIRES: one thread at a time asks for the same worker. Throws std::bad_alloc.
  WorkerScratch& of(int worker);
  // How many points ended in each status. REQUIRES: no other thread uses the set.
  std::array<uint64_t, kPointStatusEnd> status_counts() const;

 private:
  const StrategyRun& run_;
  SeamMarks* const seams_;
  std::vector<std::unique_ptr<WorkerScratch>> scratch_;
};

// Returns how many groups a block takes: about 1,000 points, which take under a millisecond at 50 neighbors, and fewer
// where a point costs more, since others wait for the end of a block. Never 0.
size_t GroupsPerBlock(const EstimatorOptions& options);

// Tells what time it is.
using BlockClock = std::chrono::steady_clock::time_point (*)();

// A block that has taken longer than kLongBlock, or more steps than WorkerScratch::kMostRunWork, ends with the group at
// hand: nobody knows beforehand what a point costs among many others in a radius, or in a cloud that is made to cost
// much. The block's other groups, and what the last run has left of its group, come in another turn.
inline constexpr std::chrono::milliseconds kLongBlock{5};

// Runs `groups` on all groups of `index`, `groups_per_block` of them a block, or fewer where those are long.
// Adds the points of each block that is done, of those that get results, to *points_done, if it is not null.
// REQUIRES: index, scratch and points_done outlive the phase.
std::unique_ptr<Phase> MakeGroupPhase(GroupPhase groups, const SpatialIndex& index, size_t groups_per_block,
                                      ScratchSet& scratch, std::atomic<size_t>* points_done,
                                      BlockClock now = &std::chrono::steady_clock::now);

}  // namespace curvd
