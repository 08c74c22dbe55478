// Estimates the sampled points of a cloud at every scale.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/index/spatial_index.h"
#include "core/scale/pilot/pilot_scratch.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Samples points of an index: the first points that get a result of leaves that lie evenly in the tree order, one of
// each leaf where there are enough. A few of them, the scouts, may go first, and tell what the others can be spared. Up
// to as many again lie between them, for clouds that need more. What is estimated depends on the index and on what is
// spared, not on threads or instruction sets. Const methods are thread-safe.
class Pilot {
 public:
  enum class Samples : uint8_t { kScouts, kOthers, kBetween };
  // At most so many points are sampled; of small clouds so many at the least, unless that takes more than kMostOfLeaf
  // of a leaf, whose neighborhoods are nearly the same.
  static constexpr size_t kMostPoints = 512, kLeastPoints = 128, kMostOfLeaf = 4;
  // So many of them are scouts, or up to twice as many; of clouds that are sampled more than once a leaf, all are.
  static constexpr size_t kLeastScouts = 64;

  // No neighborhood has more than `most_count` points, or a third of the cloud, and that of the first rung if that is
  // more. Where the index has half normals, the samples are estimated by those. REQUIRES: `index` has normals, and
  // outlives the pilot.
  Pilot(const SpatialIndex& index, uint32_t most_count);

  // Rungs that points are sampled at: at first those whose neighborhoods are not too large; 0: the cloud is too small
  // for any.
  size_t rung_count() const { return rung_count_; }
  size_t most_rungs() const { return most_rungs_; }
  // Whether there are others than scouts, and points between.
  bool HasOthers() const { return ScoutStep() > 1; }
  bool HasBetween() const { return sampled_leaf_count() < index_.leaf_count(); }
  // From now on, so many rungs. REQUIRES: 0 < count <= most_rungs().
  void SetRungs(size_t count);
  // From now on, only these methods, and those that tell noise.
  void KeepMethods(const MethodSet& methods);

  // Writes the sampled points of a group, which mostly has none, to their places in `table`, which has sample_count():
  // scouts and others share a table, those between have one of their own. A point without a neighborhood has no
  // estimates. Thread-safe for distinct groups and scratch. Errors: ErrorKind::kCancelled once the scratch is stopped.
  // May throw std::bad_alloc. REQUIRES: rung_count() > 0.
  absl::Status SampleGroup(size_t group, Samples which, PilotScratch& scratch, std::span<PilotPoint> table) const;

  // Leaves that points are sampled of, from each equally many.
  size_t sampled_leaf_count() const { return std::min(kMostPoints, index_.leaf_count()); }
  size_t samples_of_leaf() const {
    const size_t leaves = sampled_leaf_count();
    return std::clamp<size_t>((kLeastPoints + leaves - 1) / leaves, 1, kMostOfLeaf);
  }
  size_t sample_count() const { return sampled_leaf_count() * samples_of_leaf(); }
  const SpatialIndex& index() const { return index_; }

 private:
  // The place among the sampled leaves of the first that is not before this leaf.
  size_t SampledFrom(size_t leaf) const { return FirstPlace(leaf, sampled_leaf_count()); }
  // The leaf that has this place among the sampled ones.
  size_t SampledLeaf(size_t place) const { return place * index_.leaf_count() / sampled_leaf_count(); }
  bool IsSampled(size_t leaf) const {
    return SampledFrom(leaf) < sampled_leaf_count() && SampledLeaf(SampledFrom(leaf)) == leaf;
  }
  // Of the sampled leaves, every so many has scouts.
  size_t ScoutStep() const {
    return samples_of_leaf() > 1 ? 1 : std::max<size_t>(sampled_leaf_count() / kLeastScouts, 1);
  }
  // Of `count` leaves that lie evenly in the tree order, the first that is not before this leaf.
  size_t FirstPlace(size_t leaf, size_t count) const {
    const size_t leaves = index_.leaf_count();
    return (leaf * count + leaves - 1) / leaves;
  }
  // Whether the leaf lies halfway from a sampled one to the next.
  bool IsBetween(size_t leaf) const {
    const size_t count = 2 * sampled_leaf_count(), place = FirstPlace(leaf, count);
    return place % 2 == 1 && place * index_.leaf_count() / count == leaf && !IsSampled(leaf);
  }
  bool IsSampledNow(size_t leaf, Samples which) const {
    if (which == Samples::kBetween) return IsBetween(leaf);
    return IsSampled(leaf) && (SampledFrom(leaf) % ScoutStep() == 0) == (which == Samples::kScouts);
  }
  // The place in its table of the first sample of a leaf that is sampled.
  size_t PlaceOf(size_t leaf, Samples which) const {
    const size_t between = which == Samples::kBetween ? 1 : 0;
    return (SampledFrom(leaf) - between) * samples_of_leaf();
  }

  const SpatialIndex& index_;
  size_t most_rungs_ = 0, rung_count_ = 0;
  MethodSet methods_ = AllMethods();
  NeighborhoodPlan plan_{};  // of the largest neighborhoods
};

}  // namespace curvd
