// Tells from a sample of the points whether normals that were given are those of jets that were fitted to the positions
// of each point's neighbors, as core/normals/trust/plane_probe.h does of planes.
//
// Few neighbors more change a jet little: the number of neighbors is narrowed down, from rungs a factor of two apart,
// by how near the jets' normals come to the given ones, until all numbers that are left are tried.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/sample_scratch.h"
#include "core/normals/trust/fit_match.h"

namespace curvd {

// Usage: as long as AddBlocks returns true, block_count blocks of RunBlock, in any order and on any threads; then
// found(). What is found depends on the index alone, not on threads. RunBlock is thread-safe for distinct blocks and
// workers.
class JetProbe {
 public:
  // Jets that are fitted in one go, at most: two methods of eight rungs, or steps around one number of neighbors.
  static constexpr size_t kMostAtOnce = 22;

  // No neighborhood is larger than max_neighbor_count. REQUIRES: index.has_normals(); it outlives this.
  JetProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // Decides which jets are fitted next, by what was found so far; false: none. May throw std::bad_alloc.
  bool AddBlocks();
  size_t block_count() const { return (jets_.size() - first_new_) * groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // Whether noise moves fits by so little that nothing is lost by taking their normals for exact; also where nothing
  // tells. REQUIRES: as found.
  bool IsNoiseNegligible() const;
  // The jets that the normals are those of, if they are. REQUIRES: AddBlocks has returned false.
  const std::optional<FoundFit>& found() const { return found_; }

  size_t bytes() const { return fitted_.capacity() * sizeof(Vector) + jets_.capacity() * sizeof(Jet) + kFixedBytes; }
  // Of the scratch of one worker, at most; 0 where the cloud is too small for jets.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);

 private:
  static constexpr size_t kPointsPerGroup = SpatialIndex::kGroupLeaves;
  static constexpr size_t kMostJetGroups = 8;
  static constexpr size_t kMostSamples = kMostJetGroups * kPointsPerGroup;
  static constexpr size_t kFixedBytes = kMostSamples * (3 + 1) * sizeof(float) + kMostJetGroups * sizeof(size_t);
  enum class Stage : uint8_t { kNone, kNoise, kRungs, kSteps, kBends, kDone };
  using Vector = std::array<float, 3>;
  struct Jet {
    NormalMethod method;
    uint32_t count;  // of neighbors
    NormalPlan plan;
  };

  // Adds a jet, unless it is there or needs more neighbors than there are.
  void Add(NormalMethod method, uint32_t count);
  // Adds jets of the next method that comes near to the given normals, if there is one.
  void GoOnWithNextMethod();
  void AddStepsAround(size_t jet);
  size_t sample_count() const { return groups_.size() * kPointsPerGroup; }
  size_t FindJet(NormalMethod method, uint32_t count) const;
  const Vector& normal(size_t jet, size_t sample) const { return fitted_[jet * sample_count() + sample]; }
  // The median over the samples of the squared differences of a jet's normals from the given ones, or from another
  // jet's. Infinity where there are too few.
  double DifferenceFromGiven(size_t jet) const;
  double DifferenceOf(size_t jet, size_t other) const;
  // The rung of the method that comes nearest to the given normals, over what noise makes of jets of its size; none:
  // none is near.
  std::optional<size_t> NearestRung() const;
  // The jet of the method that comes nearest to them.
  size_t NearestStep() const;
  // By all jets of the method that were fitted.
  FitVotes Votes() const;
  void Find();

  const SpatialIndex& index_;
  const std::vector<size_t> groups_;
  const uint32_t most_neighbors_;
  Stage stage_ = Stage::kNone;
  std::vector<Jet> jets_;
  size_t first_new_ = 0;                       // of jets_
  NormalMethod method_ = NormalMethod::kJet2;  // of the jets of now
  size_t methods_begun_ = 0;
  double step_ = 1.0;  // of their numbers of neighbors, in doublings
  int narrowings_ = 0;
  std::vector<Vector> given_;   // by sample; NaN where there is none
  std::vector<float> noise_;    // by sample, of the first jet: its mean square
  std::vector<Vector> fitted_;  // by jet and sample; NaN where there is none
  SampleScratch<NormalScratch> scratch_;
  std::optional<FoundFit> found_;
};

}  // namespace curvd
