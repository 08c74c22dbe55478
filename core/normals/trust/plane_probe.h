// Tells from a sample of the points whether normals that were given are those of planes through the positions of each
// point's neighbors, as most programs make them: neighbors then share the errors of such normals, which the halves of a
// neighborhood would take for detail of the surface.
//
// Each neighbor that is added to those of a plane turns it, by noise and by how unevenly points lie. A given normal
// that is much nearer to the plane of some number of neighbors than to those of all other numbers was made of that
// plane. Where normals come from elsewhere, this happens by chance at few points, and at each with another number.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
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
class PlaneProbe {
 public:
  // No neighborhood is larger than max_neighbor_count. REQUIRES: index.has_normals(); it outlives this.
  PlaneProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // Decides which points are looked at next: few, and more if some of these have normals of planes. false: none. May
  // throw std::bad_alloc.
  bool AddBlocks();
  size_t block_count() const { return groups_.size(); }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // The planes that the normals are those of, if they are. REQUIRES: AddBlocks has returned false.
  const std::optional<FoundFit>& found() const { return found_; }

  size_t bytes() const { return matches_.capacity() * sizeof(Match) + groups_.capacity() * sizeof(size_t); }
  // Of the scratch of one worker, at most; 0 where the cloud is too small.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count);

 private:
  enum class Stage : uint8_t { kNone, kFew, kAll, kDone };
  // The plane that one given normal is that of.
  struct Match {
    bool is_known = false;  // whether there is a normal, and there are planes
    uint32_t count = 0;     // of its neighbors; 0: it is that of none
    FittedSample sample{};
    float farthest = 0.0f, next = 0.0f;  // squared distances of its last neighbor, and of the one after that
  };

  void LookAt(size_t group_count);
  // The plane of the normal of point i of a sample whose neighbors are in the scratch.
  static Match MatchOf(const NormalScratch& s, size_t i, const SpatialIndex& index);
  size_t KnownCount() const;
  // The samples with planes of one number of neighbors, with that number; and those with planes of all neighbors within
  // one radius, with the median of their numbers.
  std::pair<uint32_t, FitAgreement> OfOneCount() const;
  std::pair<uint32_t, FitAgreement> OfOneRadius() const;
  void Find();

  const SpatialIndex& index_;
  const NormalPlan plan_;  // of the largest planes
  Stage stage_ = Stage::kNone;
  std::vector<size_t> groups_;
  std::vector<Match> matches_;  // by sample: one point of each leaf of the groups
  SampleScratch<NormalScratch> scratch_;
  std::optional<FoundFit> found_;
};

}  // namespace curvd
