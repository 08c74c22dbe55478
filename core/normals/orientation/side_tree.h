// Joins the points of a cloud along the tree of their cheapest links: afterwards each point knows to which cluster and
// piece it belongs, and whether its normal points to the same side as that of the cluster's root.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/page_array.h"
#include "core/index/spatial_index.h"
#include "core/normals/orientation/link_forest.h"
#include "core/normals/orientation/normal_links.h"

namespace curvd {

// Points that are joined by certain links, and by uncertain ones as far as that was needed to make the cluster large
// enough. Within a piece, a tree of links joins the clusters.
struct Cluster {
  uint32_t root;     // place of a point
  uint32_t points;   // how many there are
  uint32_t piece;    // pieces are numbered in the order of their first clusters
  bool is_opposite;  // whether the root's normal points to another side than that of the piece's first cluster
};

// Boruvka's way to the minimum spanning forest (Hoppe et al., "Surface reconstruction from unorganized points", 1992,
// for why it leads): in each round every root finds its cheapest link to another one, and half of them or more follow
// it. ComesBefore makes the forest unique, whatever the threads do. It is cut where it is uncertain and both sides are
// large: that is where whole parts of a cloud come out with the wrong side.
//
// Usage: Start; Link for each chunk, until nothing is left of it; then rounds, as long as BeginRound says so: Propose
// for each chunk, Follow for each chunk, Flatten for each chunk, EndRound for each chunk; then FlattenPlaces for each
// chunk, and JoinClusters. Calls of one kind may run concurrently for distinct chunks, and all of a kind must have
// returned before the next kind begins. A chunk is kChunkGroups groups of the index.
class SideTree {
 public:
  static constexpr size_t kChunkGroups = 64;
  static constexpr size_t kChunkPoints = kChunkGroups * SpatialIndex::kGroupPoints;
  static constexpr uint32_t kNoCluster = ~uint32_t{0};
  static constexpr size_t kNoRest = ~size_t{0};
  // A link that costs more may be wrong.
  static constexpr float kCertain = 0.1f;
  // A cluster is large if it has so many points, and this share of all.
  static constexpr size_t kLeastCluster = 30, kMostLargeClusters = 1024;

  // REQUIRES: links_per_point <= kMostLinksPerPoint.
  explicit SideTree(const SpatialIndex& index, size_t links_per_point = kLinksPerPoint)
      : index_(index), plan_(LinkSearch(index, links_per_point)) {}

  size_t chunk_count() const { return (index_.point_count() + kChunkPoints - 1) / kChunkPoints; }
  // Takes memory. Errors: ErrorKind::kOutOfMemory; may throw std::bad_alloc.
  absl::Status Start();

  // Compares the normals of a chunk's points with their neighbors', from the place `first` on, which is that of the
  // chunk's first point, or what another call has returned; and keeps the links that matter. Returns kNoRest, or once
  // the searches have become long (WorkerScratch::kMostRunWork) or the links many, the place from which another call is
  // to go on.
  // Errors: ErrorKind::kCancelled once the scratch is stopped. May throw std::bad_alloc.
  absl::StatusOr<size_t> Link(size_t first, LinkScratch& links, ForestScratch& forest);

  // Whether another round is to run. Not concurrent with anything.
  bool BeginRound();
  void Propose(size_t chunk);
  void Follow(size_t chunk);
  void Flatten(size_t chunk);
  void EndRound(size_t chunk);
  void FlattenPlaces(size_t chunk);

  // Numbers the clusters in the order of their roots' places, joins them by the links that are left, and gives back
  // what only rounds need. Called once, when there are no more rounds. May throw std::bad_alloc.
  void JoinClusters();
  // REQUIRES for all that follows: JoinClusters was called.
  const std::vector<Cluster>& clusters() const { return clusters_; }
  size_t piece_count() const { return piece_count_; }
  // The fewest points of a large cluster.
  size_t least_points() const { return least_points_; }
  // kNoCluster for points without a normal.
  uint32_t cluster(size_t place) const { return parents_[place] == kNone ? kNoCluster : pieces_[parents_[place] >> 1]; }
  // Whether the point's normal, as it was when Link ran, points to another side than that of the cluster's root.
  // REQUIRES: cluster(place) != kNoCluster.
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
  // A call ends when it has so many links or more, by at most those of a group.
  static constexpr size_t kManyLinks = kChunkPoints * (kLinksPerPoint + 1);
  static constexpr int kLinkBits = 13;
  static_assert(kMostKept == size_t{1} << kLinkBits);
  static_assert(sizeof(NormalLink) == 12);
  static constexpr size_t kWordBits = 64, kChunkWords = kChunkPoints / kWordBits;

  // First the rounds that join by certain links; then those in which small clusters follow uncertain ones.
  enum class Stage { kStart, kCertain, kUncertain, kDone };

  // A place and a side: the place shifted by one, and in the lowest bit whether the sides differ.
  static uint32_t Join(uint32_t place, uint32_t opposite) { return place << 1 | opposite; }
  size_t ChunkEnd(size_t chunk) const;
  bool IsRoot(uint32_t place) const { return parents_[place] >> 1 == place; }
  bool IsSmall(uint32_t root) const { return pieces_[root] < least_points_; }
  template <typename Use>
  void ForEachRoot(size_t chunk, const Use& use);
  void StartPlace(size_t place);
  void Offer(uint32_t root, uint64_t offer);
  uint32_t TargetOf(uint32_t root) const;
  void NumberClusters();

  const SpatialIndex& index_;
  const NeighborhoodPlan plan_;
  Stage stage_ = Stage::kStart;
  std::atomic<size_t> joined_ = 0;  // in this round
  uint32_t least_points_ = 0;       // of a large cluster
  // Of each chunk, in order; once there are rounds, between the roots that there were when the last one began.
  std::vector<std::vector<NormalLink>> links_;
  std::vector<uint64_t> roots_;  // by place, a bit each: whether it is a root, of a point with a normal
  // By place. The parent of a point is its cluster's root, with the side relative to it; during rounds, of a point that
  // is no root any more, the place that was the root when it stopped being one.
  PageArray<uint32_t> parents_;
  // Of roots: cost and name of the cheapest link; once they follow, what they follow, or themselves.
  PageArray<uint64_t> offers_;
  // Of roots: how many points they have; after the rounds, the number of the cluster.
  PageArray<uint32_t> pieces_;
  PageArray<PackedArea> areas_;
  std::vector<Cluster> clusters_;
  size_t piece_count_ = 0;
};

}  // namespace curvd
