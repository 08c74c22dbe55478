// Finds closed pieces that are the inside of a hollow body's wall, whose normals point into the hollow: a closed piece
// that lies within another, nearer to it than it is large.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/normals/piece_sides.h"
#include "core/normals/side_tree.h"

namespace curvd {

// Usage: SumChunk for each chunk of the tree, unless pair_count is 0; CheckPair for each pair; then InnerPieces. Calls
// of one kind may run concurrently for distinct chunks or pairs. What is found depends on the index and the tree alone.
class HollowWalls {
 public:
  // `is_candidate`: by piece, whether it is large and closed by the sum of its normals, with normals that point outward
  // once Finish of the sides was called. May throw std::bad_alloc. REQUIRES: all outlive this.
  HollowWalls(const SpatialIndex& index, const SideTree& tree, const PieceSides& sides,
              const std::vector<uint8_t>& is_candidate);

  size_t pair_count() const { return pairs_.size(); }
  // May throw std::bad_alloc.
  void SumChunk(size_t chunk);
  void CheckPair(size_t pair);
  // The pieces that lie within an odd number of others that are so near: those whose normals are to point inward.
  std::vector<uint32_t> InnerPieces() const;

 private:
  struct Pair {
    uint32_t inner, outer;
    bool holds = false;
  };
  // A point, as far as it stands for a part of the surface.
  struct Sample {
    uint32_t piece;
    std::array<float, 3> position;
    std::array<float, 3> moment;  // area times normal that points outward
  };
  static constexpr size_t kSamples = 4096, kProbes = 256;  // of a piece

  // How many points of the piece lie between two samples.
  size_t Stride(uint32_t piece) const;
  double WindingAt(const std::array<float, 3>& position, uint32_t outer) const;

  const SpatialIndex& index_;
  const SideTree& tree_;
  const PieceSides& sides_;
  std::vector<Pair> pairs_;
  std::vector<uint8_t> is_looked_at_;         // by piece
  std::vector<std::vector<Sample>> samples_;  // of each chunk, in order
};

}  // namespace curvd
