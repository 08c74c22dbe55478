// Joins the points of a cloud along the tree of their cheapest links: afterwards each point knows to which piece it
// belongs, and whether its normal points to the same side as that of the piece's root.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/page_array.h"
#include "core/index/spatial_index.h"
#include "core/normals/link_forest.h"
#include "core/normals/normal_links.h"

namespace curvd {

// Boruvka's way to the minimum spanning forest (Hoppe et al., "Surface reconstruction from unorganized points", 1992,
// for why it leads): in each round every piece finds its cheapest link to another one, and half of the pieces or more
// follow it. ComesBefore makes the forest unique, whatever the threads do.
//
// Usage: Start; Link for each chunk; then, while HasLinks says so, rounds: Propose for each chunk, Follow for each
// chunk, Flatten for each chunk. Calls of one kind may run concurrently for distinct chunks, and all of a kind must
// have returned before the next kind begins. A chunk is kChunkGroups groups of the index.
class SideTree {
 public:
  static constexpr size_t kChunkGroups = 64;
  static constexpr size_t kChunkPoints = kChunkGroups * SpatialIndex::kGroupPoints;
  static constexpr uint32_t kNoPiece = ~uint32_t{0};
  static constexpr size_t kNoRest = ~size_t{0};

  explicit SideTree(const SpatialIndex& index) : index_(index), plan_(LinkSearch(index)) {}

  size_t chunk_count() const { return (index_.point_count() + kChunkPoints - 1) / kChunkPoints; }
  // Takes memory. Errors: ErrorKind::kOutOfMemory; may throw std::bad_alloc.
  absl::Status Start();

  // Compares the normals of a chunk's points with their neighbors', from the place `first` on, which is that of the
  // chunk's first point, or what another call has returned; and keeps the links that matter. Returns kNoRest, or once
  // the searches have become long (WorkerScratch::kMostRunWork), the place from which another call is to go on.
  // Errors: ErrorKind::kCancelled once the scratch is stopped. May throw std::bad_alloc.
  absl::StatusOr<size_t> Link(size_t first, LinkScratch& links, ForestScratch& forest);
  // Whether there are links between pieces. Not concurrent with anything.
  bool HasLinks() const;
  void Propose(size_t chunk);
  void Follow(size_t chunk);
  void Flatten(size_t chunk);

  // Gives back what only rounds need, and numbers the pieces in the order of their roots' places; returns how many they
  // are. Called once, when there are no links any more.
  size_t NumberPieces();
  // REQUIRES: NumberPieces was called. kNoPiece for points without a normal.
  uint32_t piece(size_t place) const { return parents_[place] == kNone ? kNoPiece : pieces_[parents_[place] >> 1]; }
  // Whether the point's normal, as it was when Link ran, points to another side than that of the piece's root.
  // REQUIRES: piece(place) != kNoPiece.
  bool is_opposite(size_t place) const { return (parents_[place] & 1) != 0; }
  float area(size_t place) const { return UnpackArea(areas_[place]); }

  // Gives back all memory. Only Start may follow.
  void Clear();

  // Bytes held; while a chunk runs, they change.
  size_t bytes() const;
  // Bytes of the scratch of one worker, at most.
  static size_t ScratchBytes(size_t point_count);

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  static constexpr uint64_t kNoLink = ~uint64_t{0};
  // Links of one chunk are named by 13 bits, chunks by the other 19 of 32.
  static constexpr size_t kMostKept = 2 * kChunkPoints;
  static constexpr int kLinkBits = 13;
  static_assert(kMostKept == size_t{1} << kLinkBits);
  static_assert(sizeof(NormalLink) == 12);

  // A place and a side: the place shifted by one, and in the lowest bit whether the sides differ.
  static uint32_t Join(uint32_t place, uint32_t opposite) { return place << 1 | opposite; }
  size_t ChunkEnd(size_t chunk) const;
  bool IsRoot(size_t place) const { return parents_[place] >> 1 == place && parents_[place] != kNone; }
  void StartPlace(size_t place);
  void Offer(uint32_t root, uint64_t offer);

  const SpatialIndex& index_;
  const NeighborhoodPlan plan_;
  std::vector<std::vector<NormalLink>> links_;  // of each chunk, in order
  // By place. The parent of a point is its piece's root, with the side relative to it.
  PageArray<uint32_t> parents_;
  PageArray<uint64_t> offers_;  // of roots: cost and name of the cheapest link to another piece
  // Of roots: what they follow in this round, or themselves; after the rounds, the number of the piece.
  PageArray<uint32_t> pieces_;
  PageArray<PackedArea> areas_;
};

}  // namespace curvd
