// Finds from a sample of the points with how many neighbors the normal of a point is to be compared.
//
// Where scan lines are farther from each other than the points of one are, the few nearest neighbors of a point lie on
// its own line, and no comparison leads to the next one: each line would get a side of its own. Neighbors of more
// points spread in two directions.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/sample_scratch.h"

namespace curvd {

// Usage: as long as AddBlocks returns true, block_count blocks of RunBlock, in any order and on any threads; then
// LinksPerPoint. What is found depends on the index alone, not on threads. RunBlock is thread-safe for distinct blocks
// and workers.
class LinkProbe {
 public:
  // REQUIRES: `index` has normals, of any values, and outlives this.
  LinkProbe(const SpatialIndex& index, int thread_count);

  // Decides which neighborhoods are looked at next: few neighbors, and more if these do not suffice. false: none.
  bool AddBlocks();
  size_t block_count() const { return (looked_at_ - first_rung_) * groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // From kLinksPerPoint to kMostLinksPerPoint. REQUIRES: AddBlocks has returned false.
  size_t LinksPerPoint() const;

  size_t bytes() const { return groups_.capacity() * sizeof(size_t); }
  static size_t ScratchBytes(size_t point_count);

 private:
  struct Tally {
    std::atomic<uint32_t> points = 0;
    // Of these, those whose neighbors lie on a line; and those that have neighbors on one side alone.
    std::atomic<uint32_t> on_lines = 0, one_sided = 0;
  };
  static constexpr std::array<size_t, 4> kLadder = {12, 24, 48, 96};

  bool Spreads(size_t rung, double most_on_lines, double most_one_sided) const;
  double ShareOf(size_t rung, std::atomic<uint32_t> Tally::*some) const;

  const SpatialIndex& index_;
  std::vector<NormalPlan> plans_;          // of each count that the cloud has points for
  size_t first_rung_ = 0, looked_at_ = 0;  // of those of the moment, and after the last of them
  std::vector<size_t> groups_;
  std::array<Tally, kLadder.size()> tallies_;
  SampleScratch<NormalScratch> scratch_;
};

}  // namespace curvd
