// Finds closed pieces that are the inside of a hollow body's wall, whose normals point into the hollow: a closed piece
// that lies within another, nearer to it than it is large. Farther away it may be that as well, or a body.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/normals/orientation/piece_sides.h"
#include "core/normals/orientation/side_tree.h"

namespace curvd {

// Usage, unless pair_count is 0: SumChunk for each chunk of the tree; GroupSamples; CheckPair for each pair. Then
// InnerPieces. SumChunk and CheckPair may run concurrently for distinct chunks or pairs. What is found depends on the
// index and the tree alone. Takes less than a millisecond a pair.
class HollowWalls {
 public:
  // With more pairs that may be walls than that, nothing is looked for: those that were left out would turn what lies
  // within. Of the other pairs so many are looked at, at most.
  static constexpr size_t kMostPairs = 1024;

  // `is_candidate`: by piece, whether it is large and closed by the sum of its normals, with normals that point outward
  // once Finish of the sides was called. May throw std::bad_alloc. REQUIRES: all outlive this.
  HollowWalls(const SpatialIndex& index, const SideTree& tree, const PieceSides& sides,
              const std::vector<uint8_t>& is_candidate);

  size_t pair_count() const { return pairs_.size(); }
  // These may throw std::bad_alloc.
  void SumChunk(size_t chunk);
  void GroupSamples();
  void CheckPair(size_t pair);
  // The pieces whose normals are to point inward, ascending: each lies within another that is so near, and the nearest
  // of those is no such piece itself, since what lies in a hollow is a body.
  std::vector<uint32_t> InnerPieces() const;
  // How many pieces nothing tells the side of: each lies within another that is too far away for InnerPieces to take it
  // as an inside, and that is none itself. It bounds a hollow there, or a body of its own.
  size_t AmbiguousCount() const;

  size_t bytes() const;
  // Bytes held at most.
  static size_t MostBytes(size_t point_count);

 private:
  struct Pair {
    uint32_t inner, outer;
    bool is_thin = false;  // what lies between the two may be a wall
    bool holds = false;    // whether the one lies within the other
  };
  // A point, as far as it stands for a part of the surface.
  struct Sample {
    uint32_t piece;
    std::array<float, 3> position;
    std::array<float, 3> moment;  // area times normal that points outward
  };
  static constexpr size_t kSamples = 512, kProbes = 64;  // of a piece, about and at most

  static constexpr uint32_t kNone = ~uint32_t{0};

  // The piece of least volume around each; of thin pairs alone, or of all.
  std::vector<uint32_t> NearestAround(bool thin_alone) const;
  // How many points of the piece lie between two samples.
  size_t Stride(uint32_t piece) const;
  double WindingAt(const std::array<float, 3>& position, uint32_t outer) const;

  const SpatialIndex& index_;
  const SideTree& tree_;
  const PieceSides& sides_;
  std::vector<Pair> pairs_;
  std::vector<uint8_t> is_looked_at_;        // by piece
  std::vector<std::vector<Sample>> chunks_;  // until they are grouped, in order
  std::vector<std::vector<Sample>> pieces_;  // of each piece that is looked at, in order
};

}  // namespace curvd
