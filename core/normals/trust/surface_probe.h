// Tells from a sample of the points whether normals that were given stand on the surface that the positions show.
//
// They do not where positions were moved, turned or mirrored without them, where they are placeholders, or where they
// were made of neighbors that lie on one scan line. Curvature that is estimated from them then means nothing, and
// nothing else may show it: such normals can be as smooth as right ones.
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

namespace curvd {

// Of the sampled points whose neighbors lie near a plane, and spread in it.
struct NormalsOffSurface {
  uint32_t sampled_points = 0;
  // Those whose normal is more than 30 degrees from that of the plane.
  uint32_t off_points = 0;

  double share() const { return sampled_points > 0 ? static_cast<double>(off_points) / sampled_points : 0.0; }
};

// From this share of points off the surface on, a person should know. Normals with noise of 0.2 rad along each tangent
// have 0.03, and with 0.35 rad 0.3.
inline constexpr double kMostOffSurface = 0.3;

// Usage: as long as AddBlocks returns true, block_count blocks of RunBlock, in any order and on any threads; then
// found(). What is found depends on the index alone, not on threads. RunBlock is thread-safe for distinct blocks and
// workers.
class SurfaceProbe {
 public:
  // No neighborhood is larger than max_neighbor_count. REQUIRES: index.has_normals(); it outlives this.
  SurfaceProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count);

  // Decides which neighborhoods are looked at next: small ones, and larger ones while these show planes at too few
  // points. false: none.
  bool AddBlocks();
  size_t block_count() const { return (groups_.size() + kGroupsPerBlock - 1) / kGroupsPerBlock; }
  // Errors: ErrorKind::kCancelled once *stopped is true. May throw std::bad_alloc.
  absl::Status RunBlock(size_t block, int worker, const std::atomic<bool>& stopped);
  // None where too few points lie on planes: the cloud is too small, or no surface. REQUIRES: AddBlocks has returned
  // false.
  std::optional<NormalsOffSurface> found() const;

  size_t bytes() const { return groups_.capacity() * sizeof(size_t); }
  // Of the scratch of all workers together, at most; 0 where the cloud is too small.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count);

 private:
  struct Tally {
    std::atomic<uint32_t> points = 0;  // that were looked at
    std::atomic<uint32_t> on_planes = 0, off = 0;
  };
  // So many take about a millisecond, and workers need no more scratch than blocks.
  static constexpr size_t kGroupsPerBlock = 16;
  static constexpr std::array<uint32_t, 4> kLadder = {16, 48, 192, 768};

  // Whether the neighborhoods of the moment show enough planes.
  bool Tells() const;
  void Take(size_t i, const NormalScratch& scratch, Tally& tally) const;

  const SpatialIndex& index_;
  std::vector<NormalPlan> plans_;  // of each count that the cloud has points for
  size_t looked_at_ = 0;           // so many of these; the last one is that of the moment
  std::vector<size_t> groups_;
  std::array<Tally, kLadder.size()> tallies_;
  SampleScratch<NormalScratch> scratch_;
};

}  // namespace curvd
