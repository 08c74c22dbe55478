// Tells from a sample of the points whether the sides of normals contradict how they were made, once all normals point
// where they should. Two things show what the winding number does not:
//
// - A fit takes its neighborhood as one sheet. Where a part of the surface is thinner than neighborhoods are wide, they
//   hold both of its sheets, and the narrow sides between these as well: normals there come out like those of the
//   sheets, so that nothing tells on which side they are. The normals look calm, as does their winding number. But then
//   much of a point's neighborhood has opposed normals.
// - Where a patch of a ball is turned, the winding number falls at all points by nearly as much, those of the patch
//   included: it varies no more than before. But then the normals of neighbors along one sheet are opposed around the
//   patch.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/normal_fit.h"
#include "core/normals/sample_scratch.h"

namespace curvd {

// Of the sampled points of a group that have normals, and of their neighbors that have.
struct SideCounts {
  double opposed_shares = 0.0;  // of the neighbors in the fit, summed over the points
  size_t points = 0;
  size_t pairs = 0, torn_pairs = 0;  // of links
  bool is_noisy = false;             // whether the group is fitted as the noisy part is
  double weight = 1.0;               // of its points, where more of them are looked at than of other groups
};

// Usage: block_count blocks of RunBlock, in any order and on any threads; then the shares. What is found depends on the
// index and the fit alone, not on threads. RunBlock is thread-safe for distinct blocks and workers. A worker's scratch
// is that of the fit (NormalScratch::MostBytes).
class SideProbe {
 public:
  // `fit`: what the normals of the index were made by. REQUIRES: index.has_normals(), NaN where a point has none; it
  // outlives this; by count, it holds as many points.
  SideProbe(const SpatialIndex& index, const NormalFit& fit, int thread_count);

  size_t block_count() const { return groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // Of the sampled points and their neighbors, the share of those neighbors whose normals are more than a right angle
  // from the point's: the mean over the points. REQUIRES: all blocks have run.
  double OpposedShare() const;
  // Of the pairs of a sampled point and one of its kLinksPerPoint neighbors that lie along one sheet, the share of
  // those whose normals point to different sides of it. Of two parts of unlike noise, that of the one where it is
  // larger: the other one may have most of the pairs, and no torn one. REQUIRES: all blocks have run.
  double TornShare() const;

  size_t bytes() const { return counts_.capacity() * sizeof(counts_[0]); }

 private:
  const SpatialIndex& index_;
  const NormalPlan fit_;
  const NeighborhoodPlan links_;
  std::vector<size_t> groups_;
  std::vector<SideCounts> counts_;  // by block
  SampleScratch<NormalScratch> scratch_;
};

}  // namespace curvd
