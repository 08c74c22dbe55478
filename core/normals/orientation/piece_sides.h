// To which side of the surface the normals of a piece of a cloud point, once they agree with each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/index/spatial_index.h"
#include "core/normals/orientation/side_tree.h"

namespace curvd {

// Sums over the points of a cluster, or of a piece, whose normals are taken in its root's orientation.
struct PieceSums {
  static constexpr float kNoFloat = std::numeric_limits<float>::infinity();

  uint32_t number = 0;  // of the cluster, or of the piece
  uint64_t points = 0;
  uint64_t kept_points = 0;  // whose normals agree with the root's
  double area = 0.0;
  double kept_area = 0.0;              // of those
  std::array<double, 3> center{};      // times area
  std::array<double, 3> normal_sum{};  // times area
  double flux = 0.0;                   // of the position
  // The box of the points.
  std::array<float, 3> least = {kNoFloat, kNoFloat, kNoFloat}, most = {-kNoFloat, -kNoFloat, -kNoFloat};

  // The same sums where the root is turned.
  PieceSums Turned() const;
  void Add(const PieceSums& other);
};

// The normals of a closed surface add up to less than this share of its area, holes and all.
inline constexpr double kMostClosedShare = 0.25;

bool IsClosed(const PieceSums& piece);
// How the side of a piece is chosen.
struct SideRule {
  bool keeps_majority = false;  // normals were given: an open piece keeps the side that most of them have
  bool all_closed = false;      // pieces are closed whatever the sum of their normals
};
// Whether the normals of a piece have to be turned, all of them, once they agree with the root: a closed piece is to
// have normals that point outward; an open one keeps the side that most of its area has, or most of its points if they
// lie at one place, if rule.keeps_majority; else the largest component of its mean normal is to be positive.
bool IsToBeTurned(const PieceSums& piece, const SideRule& rule);

// Sums the pieces of a tree. Usage: SumChunk for each chunk of the tree, in any order and on any threads; then Finish.
// The sums depend on the index and the tree alone.
class PieceSides {
 public:
  // REQUIRES: JoinClusters was called. `tree` and `index` outlive the sides.
  PieceSides(const SpatialIndex& index, const SideTree& tree)
      : index_(index), tree_(tree), chunks_(tree.chunk_count()) {}

  // May throw std::bad_alloc.
  void SumChunk(size_t chunk);
  void Finish(const SideRule& rule);

  // REQUIRES for all that follows: Finish was called.
  const std::vector<PieceSums>& pieces() const { return pieces_; }
  // Whether the normals of a cluster have to be turned, besides those that are opposite to its root's.
  bool is_turned(uint32_t cluster) const { return turned_[cluster] != 0; }
  void Turn(uint32_t cluster) { turned_[cluster] ^= 1; }
  size_t bytes() const;

 private:
  const SpatialIndex& index_;
  const SideTree& tree_;
  std::vector<std::vector<PieceSums>> chunks_;
  std::vector<PieceSums> pieces_;
  std::vector<uint8_t> turned_;  // by cluster
};

}  // namespace curvd
