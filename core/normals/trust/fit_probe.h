// Tells from a sample of the points whether normals that were given are those of fits to the positions, as scanners'
// programs make them: neighbors then share the errors of such normals, which the halves of a neighborhood would take
// for detail of the surface.
//
// Planes and jets are fitted to the neighbors of each sampled point. The noise of the positions, which shows in what
// jets leave of them, moves these fits. Normals that do not come from the positions differ from a fit's by this much at
// least, as exact ones do. Those that were made of about as many neighbors have most of it in common with the fit.
// Where jets of few and of many neighbors find distinct surfaces, nothing can be told.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/phase.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// Usage: as long as AddFits returns true, block_count blocks of RunBlock, in any order and on any threads; then
// found(). What is found depends on the index alone, not on threads. RunBlock is thread-safe for distinct blocks and
// workers.
class FitProbe {
 public:
  // No neighborhood is larger than max_neighbor_count. REQUIRES: index.has_normals(); it outlives this.
  FitProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // Decides what is to be fitted next, by what was found so far; false: nothing. May throw std::bad_alloc.
  bool AddFits();
  size_t block_count() const { return (fits_.size() - first_new_) * groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // The fit that the normals share their errors with, if they are those of fits. REQUIRES: AddFits has returned false.
  const std::optional<NormalFit>& found() const { return found_; }

  size_t bytes() const {
    return fitted_.capacity() * sizeof(Fitted) + given_.capacity() * sizeof(Normal) + fits_.capacity() * sizeof(Fit) +
           groups_.capacity() * sizeof(size_t);
  }
  // Of the scratch of one worker, at most.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);

 private:
  static constexpr size_t kPointsPerGroup = SpatialIndex::kGroupLeaves;
  enum class Stage : uint8_t { kNone, kNoise, kCoarse, kFine, kDone };
  using Vector = std::array<double, 3>;
  using Normal = std::array<float, 3>;
  struct Fit {
    NormalMethod method;
    uint32_t count;  // of neighbors
    NormalPlan plan;
  };
  // What a fit makes of a sampled point; NaN where it makes nothing.
  struct Fitted {
    Normal normal;
    float radius;       // of the neighborhood
    float mean_square;  // of the neighbors' distances from the fit
  };

  // Adds a fit, unless it is there or has more neighbors than the cloud has.
  void Add(NormalMethod method, double count);
  // Which fit is of that method and has the number of neighbors nearest to `count`; none of that method: fits_.size().
  size_t NearestFit(NormalMethod method, uint32_t count) const;
  size_t sample_count() const { return groups_.size() * kPointsPerGroup; }
  const Fitted& fitted(size_t fit, size_t sample) const { return fitted_[fit * sample_count() + sample]; }
  Vector GivenOf(size_t sample) const { return {given_[sample][0], given_[sample][1], given_[sample][2]}; }
  // On the side of the given one.
  Vector NormalOf(size_t fit, size_t sample) const;
  // The variance of the positions that a jet leaves at a sample, and the median over all; infinity where it fits
  // nothing.
  double VarianceLeftBy(size_t jet, size_t sample) const;
  double LeftBy(size_t jet) const;
  // Whether normals may be told to be those of the fit.
  bool IsCandidate(size_t fit) const;
  // The variance of the positions' noise, in the index's unit: the least that a jet leaves.
  double NoiseOfPositions() const;
  // Such noise around a sample; the squared error of a fit's normal that it makes; and the median of that of a plane of
  // few neighbors.
  double NoiseAt(size_t sample) const;
  double NoiseOf(size_t fit, size_t sample) const;
  double NoiseOfFew() const;
  // The squared differences of a fit's normals from those of another, or the given ones, over what noise makes of the
  // fit's: the mean, for errors that are Gaussian. Infinity where there are too few.
  double DifferenceOf(size_t fit, std::optional<size_t> other) const;
  // Whether fits of few and of many neighbors find the same surface, but for noise.
  bool AreSettled() const;
  // The candidate that is nearest to the given normals; if there is none, with a difference of infinity.
  struct Nearest {
    size_t fit;
    double difference;
  };
  Nearest FindNearest() const;
  void Find();

  const SpatialIndex& index_;
  const std::vector<size_t> groups_;
  const size_t most_neighbors_;
  Stage stage_ = Stage::kNone;
  std::vector<Fit> fits_;
  size_t first_new_ = 0;                                 // of fits_
  double noise_ = 0.0;                                   // variance of the positions', in the index's unit
  std::vector<Normal> given_;                            // by sample
  std::vector<Fitted> fitted_;                           // by fit and sample
  std::vector<std::unique_ptr<NormalScratch>> scratch_;  // by worker
  std::optional<NormalFit> found_;
};

// Runs the probe's blocks of now. REQUIRES: it outlives the phase.
std::unique_ptr<Phase> MakeFitProbePhase(FitProbe& probe, std::string_view name);

}  // namespace curvd
