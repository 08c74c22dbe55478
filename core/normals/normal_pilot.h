// Finds from a sample of the points how many neighbors normals should be made of, and by which method.
//
// Each sampled point gets normals from jets of degree 2 and 4 at a ladder of neighbor counts. What noise does to a
// normal follows from the residuals of the fits and from where the neighbors lie: the covariance of the coefficients of
// least squares. What the surface's bends beyond the jet do to it shows in how the normal changes with
// K, in excess of what noise explains. The sum of both is least at the chosen scale. Bends have a larger weight where
// curvature is made of the normals: it averages their noise, but cannot undo what was smoothed away. Where one part of
// the sample is much noisier than the rest, each part gets the scale that is best for it (noisy_parts.h).
// Where edges of the surface make the best scale small, points away from them get a larger one (edges/edge_parts.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/normals/chosen_fit.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/normal_fit.h"
#include "core/normals/normal_options.h"
#include "core/normals/sample_scratch.h"
#include "core/normals/sample_table.h"
#include "core/normals/sample_view.h"

namespace curvd {

// Usage: block_count blocks of RunBlock, in any order and on any threads; then Choose. What is chosen depends on the
// index alone, not on threads. RunBlock is thread-safe for distinct blocks and workers.
class NormalPilot {
 public:
  // At most so many points are sampled.
  static constexpr size_t kMostGroups = 128;
  // No scale has more neighbors: what these could still smooth, whoever uses the normals can, at less cost.
  static constexpr uint32_t kMostNeighbors = 1086;

  // `method`: the one to find a scale for; none: the better of kJet2 and kJet4. No neighborhood is larger than
  // max_neighbor_count. REQUIRES: `index` has normals, of any values, and outlives the pilot.
  NormalPilot(const SpatialIndex& index, std::optional<NormalMethod> method, uint32_t max_neighbor_count,
              int thread_count, NormalAim aim);

  // 0 where the cloud is too small for a choice.
  size_t block_count() const { return table_.candidates().size() * table_.groups().size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // One scale; or two, where one part of the cloud is much noisier than the other (NoisyPart), or where there are edges
  // (EdgePart); squared_error is then that of the one scale without an edge part. REQUIRES: all blocks have run.
  ChosenFit Choose() const;
  // The squared error that noise makes of normals of such a fit, as the nearest scale of the sample shows it; none
  // where no point of the sample told. REQUIRES: as Choose; both methods are looked at.
  std::optional<double> NoiseOf(NormalMethod method, uint32_t neighbor_count) const;

  // Bytes that the pilot holds, but for its workers' scratch; and that the scratch of one worker holds at most.
  size_t bytes() const { return table_.bytes(); }
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);
  // What block_count is at most for so many points.
  static size_t MostBlocks(size_t point_count, uint32_t max_neighbor_count);

 private:
  ChosenFit ChooseFrom(const SampleView& view) const;

  const SpatialIndex& index_;
  const NormalAim aim_;
  const NormalFit fallback_;  // where the sample tells nothing
  SampleTable table_;
  SampleScratch<NormalScratch> scratch_;
};

}  // namespace curvd
