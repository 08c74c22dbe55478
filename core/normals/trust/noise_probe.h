// Tells from a sample of the points whether the errors of given normals follow the noise of the positions: those of all
// normals do that were made of these positions, in whatever way, and then neighbors share them.
//
// At a point, the slope of a plane through few neighbors is that of the surface and what noise of their heights makes.
// The slope r of the given normal is that of the surface and the normal's own error. Planes through half of these
// neighbors each, with the slopes s1 and s2, have independent noise: the mean of r (s1 + s2) / 2 - s1 s2 over the
// sample is that of the normal's error times the noise. It is 0 where normals come from elsewhere, whatever their noise
// is. Where neighbors share errors of their heights it is below 0: normals that were smoothed, and show less of the
// bends, cannot be told from positions that are wrong. Bends of the surface are taken away before, as the other normals
// around the point tell them.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/neighbors/collect.h"
#include "core/index/spatial_index.h"
#include "core/normals/sample_scratch.h"

namespace curvd {

// Usage: as long as AddBlocks returns true, block_count blocks of RunBlock, in any order and on any threads; then
// SquaredError. What is found depends on the index alone, not on threads. RunBlock is thread-safe for distinct blocks
// and workers.
class NoiseProbe {
 public:
  // Those of the largest planes, and of the surface around them, the point itself included.
  static constexpr uint32_t kNeighbors = 129;

  // REQUIRES: index.has_normals(); it outlives this.
  NoiseProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // Decides which points are looked at next: few, and more unless these show that bends or rounding decide, or many
  // points are copies of others, which share their noise. false: none, as where the cloud is too small, or no
  // neighborhood may be so large. May throw std::bad_alloc.
  bool AddBlocks();
  size_t block_count() const { return block_count_; }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // The squared error of the normals in radians, if it follows the noise of the positions; none where it is that of
  // normals from elsewhere, or nothing tells. REQUIRES: AddBlocks has returned false.
  std::optional<double> SquaredError() const;

  size_t bytes() const { return samples_.capacity() * sizeof(Sample) + groups_.capacity() * sizeof(size_t); }
  // Of the scratch of one worker, at most; 0 where block_count is.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);

 private:
  // Neighbors of the planes, and those that tell how the surface bends around the point, which are never fewer than
  // those of the rung before. Four times as many are far enough from most normals that share the point's noise, and
  // eight times as many from those of fits that were smoothed.
  struct Rung {
    size_t planes, around;
  };
  static constexpr std::array<Rung, 5> kRungs = {{{12, 48}, {16, 64}, {24, 96}, {16, 128}, {32, 128}}};
  static_assert(kNeighbors == kRungs.back().around + 1);
  // Of one rung at one point: squares and products of slopes, as far as the normals around the point leave something of
  // them, over both axes.
  struct Sample {
    double noise = 0.0;    // that halves of the neighbors do not share, squared; NaN: nothing is known
    double bends = 0.0;    // what heights that the normals' slopes make would add to it
    double surface = 0.0;  // of one half times the other
    double shared = 0.0;   // of the normal times the mean of the halves, less `surface`
    double normal = 0.0;   // squared
  };
  // What one rung tells.
  struct Finding {
    double deviations;  // how sure it is that errors follow noise: in standard errors
    double squared_error;
  };

  // Of the samples that differ from most no more than chance has it.
  struct Means {
    double most_noise, most_normal;
    double count;
    Sample of;  // NaN where nothing counts

    bool Counts(const Sample& s) const { return s.noise <= most_noise && s.normal <= most_normal; }
  };
  static constexpr std::array<double Sample::*, 5> kMembers = {&Sample::noise, &Sample::bends, &Sample::surface,
                                                               &Sample::shared, &Sample::normal};

  // Adds what the neighbors in the scratch tell of their point.
  void Take(const CollectScratch& scratch, size_t sample);
  Sample& sample(size_t rung, size_t i) { return samples_[rung * sample_count() + i]; }
  size_t sample_count() const { return groups_.size() * SpatialIndex::kGroupLeaves; }
  std::span<const Sample> SamplesOf(size_t rung) const {
    return std::span(samples_).subspan(rung * sample_count(), sample_count());
  }
  static Means MeansOf(std::span<const Sample> samples);
  // Whether the rest may tell something, by the points that were looked at first.
  bool MayTell() const;
  std::optional<Finding> FindingAt(size_t rung) const;

  const SpatialIndex& index_;
  std::vector<size_t> groups_;  // those that are looked at first, then the others
  size_t scout_count_ = 0;      // of the first
  size_t first_block_ = 0, block_count_ = 0;
  std::optional<NeighborhoodPlan> plan_;
  std::vector<Sample> samples_;  // of each rung one for each leaf of the groups
  SampleScratch<CollectScratch> scratch_;
};

}  // namespace curvd
