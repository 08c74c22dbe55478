// The winding number of the surface for which a cloud and its normals stand (Barill et al., "Fast winding numbers for
// soups and clouds", 2018), at some of its points, and what each cluster of the cloud adds to it.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/normals/orientation/side_tree.h"

namespace curvd {

// Where the field is taken, and how many points of the piece that place stands for.
struct FieldSample {
  uint32_t place;
  float weight;
};

// The field of a piece, other pieces left out, at samples of its points.
struct FieldPiece {
  uint32_t piece = 0;
  std::vector<uint32_t> clusters{};  // ascending
  std::vector<FieldSample> samples{};
  // What each of the clusters adds at each sample if the normal of the cluster's root points outward: cluster by
  // cluster. Where all of a piece's sides are right, that comes to one half.
  std::vector<float> values{};
  // Of each cluster the sum of area times normal, in the same orientation; and the area of all.
  std::vector<std::array<float, 3>> moments{};
  float area = 0.0f;

  std::span<const float> values_of(size_t cluster) const { return {&values[cluster * samples.size()], samples.size()}; }
};

// Usage: SumChunk for each chunk of the tree; Finish; then Sample for each block. Calls of one kind may run
// concurrently for distinct chunks or blocks. The values depend on the index and the tree alone.
class WindingField {
 public:
  // So many samples are spread over the cloud, and each cluster has at least kLeastOfCluster, or all of its points.
  static constexpr size_t kSpreadSamples = 2048, kLeastOfCluster = 4;

  // `wanted`: the pieces that are looked at, by number, ascending. May throw std::bad_alloc.
  // REQUIRES: JoinClusters was called. `tree` and `index` outlive the field.
  WindingField(const SpatialIndex& index, const SideTree& tree, const std::vector<uint32_t>& wanted);

  // These may throw std::bad_alloc.
  void SumChunk(size_t chunk);
  void Finish();

  size_t block_count() const { return blocks_.size(); }
  // Fills in the values. Returns early once *stopped is true.
  void Sample(size_t block, const std::atomic<bool>& stopped);

  std::vector<FieldPiece>& pieces() { return pieces_; }
  size_t bytes() const;
  // Bytes held at most, beyond BytesPerPoint.
  static size_t MostBytes(size_t point_count);

 private:
  // What the points of a cluster below a node look like from far away: a dipole. Normals are in the orientation of the
  // cluster's root.
  struct Dipole {
    uint32_t cluster;
    uint32_t points;
    float area;
    std::array<float, 3> center;  // of area
    std::array<float, 3> moment;  // sum of area times normal
  };
  struct Place {
    size_t node;  // of the index
    size_t first_leaf;
    size_t leaves;
    bool is_group() const { return leaves <= SpatialIndex::kGroupLeaves; }
    Place Left() const { return {node + 1, first_leaf, SpatialIndex::LeftLeaves(leaves)}; }
    Place Right() const {
      const size_t left = SpatialIndex::LeftLeaves(leaves);
      return {SpatialIndex::RightChild(node, leaves), first_leaf + left, leaves - left};
    }
  };
  struct Range {
    size_t first, last;  // of dipoles_
  };
  struct SampleBlock {
    size_t piece, first, last;
  };

  static Dipole Sum(const Dipole& a, const Dipole& b);
  static size_t GroupOf(const Place& place) { return place.first_leaf / SpatialIndex::kGroupLeaves; }
  // A node over whole groups is named by the group of its right half's first leaf.
  static size_t NameOf(const Place& place) { return GroupOf(place.Right()); }
  const Range& RangeOf(const Place& place) const;
  bool IsLookedAt(uint32_t cluster) const { return column_[cluster] != kNoColumn; }
  void SumGroup(size_t group, std::vector<Dipole>& out) const;
  Range SumBelow(const Place& place);
  void ChooseSamples();
  void FillSample(size_t sample, FieldPiece& piece) const;
  template <typename Add>
  void VisitGroup(const Place& place, uint32_t piece, const Add& add) const;

  static constexpr uint32_t kNoColumn = ~uint32_t{0};

  const SpatialIndex& index_;
  const SideTree& tree_;
  std::vector<std::vector<Dipole>> chunks_;  // of groups, in order
  std::vector<Range> of_groups_;
  std::vector<Range> above_groups_;
  std::vector<Dipole> dipoles_;     // of each node, by cluster
  std::vector<uint32_t> column_;    // by cluster: its place among those of its piece
  std::vector<uint32_t> field_of_;  // by piece: which of pieces_
  std::vector<FieldPiece> pieces_;
  std::vector<SampleBlock> blocks_;
};

}  // namespace curvd
