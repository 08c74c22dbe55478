// Whether the normals of a closed cloud all point to one side: the winding number of the surface for which the points
// and their normals stand (Barill et al., "Fast winding numbers for soups and clouds", 2018) is one half at each of its
// points if they do.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/index/spatial_index.h"
#include "core/normals/side_tree.h"

namespace curvd {

// Usage: Start; SumChunk for each chunk of the tree; SumNodes; Sample for each block; then value. Calls of one kind may
// run concurrently for distinct chunks or blocks. The value depends on the index and the tree alone.
class WindingCertificate {
 public:
  // REQUIRES: the normals of `index` are oriented. `tree` gives the areas; both outlive the certificate.
  WindingCertificate(const SpatialIndex& index, const SideTree& tree) : index_(index), tree_(tree) {}

  // Errors: ErrorKind::kOutOfMemory; may throw std::bad_alloc.
  absl::Status Start();
  void SumChunk(size_t chunk);
  void SumNodes();
  size_t block_count() const { return (samples_.size() + kBlockSamples - 1) / kBlockSamples; }
  // Returns early once *stopped is true; there is no value then.
  void Sample(size_t block, const std::atomic<bool>& stopped);
  // With w for the winding number at a sampled point, 1 - mean(w)^2 / mean(w^2): free of the scale of the areas, 0
  // where w is the same everywhere, 1 where it has both signs alike. 2 if the mean is not positive.
  double value() const;

  size_t bytes() const { return nodes_.bytes() + samples_.capacity() * sizeof(double); }

 private:
  // What the points below a node look like from far away: a dipole.
  struct Node {
    std::array<float, 3> center;  // of area
    float reach;                  // no point is farther from the center
    std::array<float, 3> moment;  // sum of area times normal
    float area;
  };
  static constexpr size_t kMostSamples = 4096;
  static constexpr size_t kBlockSamples = 64;

  // Nodes over whole groups alone are kept: in the order of the index's nodes, without those below a group.
  static size_t LeftGroups(size_t leaves) { return SpatialIndex::LeftLeaves(leaves) / SpatialIndex::kGroupLeaves; }
  struct Place {
    size_t node;        // here
    size_t index_node;  // in the index
    size_t first_leaf;
    size_t leaves;
    bool is_group() const { return leaves <= SpatialIndex::kGroupLeaves; }
  };
  static Place Left(const Place& parent);
  static Place Right(const Place& parent);
  size_t NodeOfGroup(size_t group) const;
  void Measure(const Place& place, Node& node) const;
  Node SumBelow(const Place& place);
  double WindingNumber(size_t place) const;
  double OfGroup(size_t first_leaf, size_t leaves, const float* query, double softening) const;

  const SpatialIndex& index_;
  const SideTree& tree_;
  PageArray<Node> nodes_;
  std::vector<double> samples_;
};

}  // namespace curvd
