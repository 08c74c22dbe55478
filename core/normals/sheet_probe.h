// Tells from a sample of the points whether neighborhoods of a cloud hold one noisy sheet of a surface, or two sheets
// that lie nearer to each other than the neighborhoods are wide.
//
// To the residuals of a fit, a thin plate looks like noise: normals made of so many neighbors that they average the
// noise are then those of both sheets at once, and nothing tells which side is outside. What differs is the shape of
// the distribution. The square of Geary's ratio of mean deviation and standard deviation ("The ratio of the mean
// deviation to the standard deviation as a test of normality", 1935) is 2/pi = 0.64 for noise that is normal, 0.75 for
// noise that is even, and 1 for two sheets of which each has as many points as the other.
#pragma once

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

// Residuals that are no more even than that are noise, not sheets.
inline constexpr double kMostEvenNoise = 0.7;

// Lengths are in the index's unit.
struct SheetFinding {
  // Of the points of one sheet, in the median; 0 where the cloud is too small to tell.
  double spacing = 0.0;
  // Standard deviation of the positions along the normal; 0 where there are two sheets that could not be told apart.
  double noise = 0.0;
  // The square of Geary's ratio in neighborhoods that are large enough to show the shape of the noise: the largest of
  // the medians. 0 where there are none.
  double evenness = 0.0;
  // Whether the residuals are more even than those of noise, and too large for rounding or bends to explain.
  bool unlike_noise = false;
  bool two_sheets = false;
  // The most neighbors that come from one sheet, among the counts that were tried, or few where all reach both.
  uint32_t neighbor_count = 0;
  // Whether those come from both sheets all the same: these are nearer to each other than the points of each.
  bool is_mixed = false;
};

// Usage: block_count blocks of RunBlock, in any order and on any threads; then Find. What is found depends on the index
// alone, not on threads. RunBlock is thread-safe for distinct blocks and workers.
class SheetProbe {
 public:
  // No neighborhood is larger than max_neighbor_count. REQUIRES: `index` has normals, of any values, and outlives this.
  SheetProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // 0 where the cloud is too small.
  size_t block_count() const { return plans_.size() * groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // REQUIRES: all blocks have run.
  SheetFinding Find() const;

  size_t bytes() const { return outcomes_.capacity() * sizeof(Outcome); }
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);

 private:
  // Of the fit of a quadric to the neighbors of one sampled point.
  struct Outcome {
    float radius;
    float variance;  // of the residuals; NaN without a fit
    float evenness;  // Geary's ratio, squared
  };
  // Medians over the sample.
  struct Rung {
    uint32_t count;
    double radius, deviation, evenness;
  };
  std::vector<Rung> Rungs() const;

  const SpatialIndex& index_;
  std::vector<uint32_t> counts_;
  std::vector<NormalPlan> plans_;  // of each count
  std::vector<size_t> groups_;
  std::vector<Outcome> outcomes_;  // of each count and sampled point
  SampleScratch<NormalScratch> scratch_;
};

}  // namespace curvd
