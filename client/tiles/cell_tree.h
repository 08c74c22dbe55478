// Cells that divide a cloud by planes into parts of about as many points, and a tree to find them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tiles/box.h"

namespace curv {

// A part of space. Its points are those at `first` to `first + count` of the store, wherever in the tree it is.
struct CellNode {
  std::array<int32_t, 2> children{-1, -1};  // -1: a cell. Else what is below the cut, and the rest
  int32_t axis = 0;                         // of the cut
  int32_t tile = -1;                        // if the points are those of a tile, its number
  double cut = 0.0;                         // below it: coordinates less than this
  Box box{};                                // around the points, as small as possible
  uint64_t first = 0;
  uint64_t count = 0;

  bool is_cell() const { return children[0] < 0; }
};

// Nodes come in the order of their points: a parent, its lower child with all below, its upper child. Const methods are
// thread-safe.
class CellTree {
 public:
  CellTree() = default;

  static constexpr size_t kEdgeBytes = 400;

  // How to divide.
  struct Parts {
    uint64_t tiles = 1;                                            // 1 or more
    uint64_t cells_per_tile = 1;                                   // 1 or more
    double most_extent = std::numeric_limits<double>::infinity();  // of a tile, on any axis; above 0
    // Points of the sample whose neighbors are looked at, with about kEdgeBytes each: 2 or more.
    uint64_t most_edge_points = uint64_t{1} << 18;
  };

  // Divides space so that each of `tiles` parts, and within them each of `cells_per_tile` cells, hold about as many
  // points of the sample. Tiles are cut where few neighbors are parted (NeighborEdges), and what is longer than
  // `most_extent` then, in the middle, into parts of fewer points. Cells are cut across the longest extent. Points at
  // one place stay together, so there may be fewer cells. Takes O(n log n). REQUIRES: the sample is not empty, finite,
  // and in random order.
  static CellTree Divide(std::vector<Position> sample, const Parts& parts);

  // Reads what Bytes returned. INVALID_ARGUMENT if the bytes are of no tree, with counts, boxes and tiles that fit.
  static absl::StatusOr<CellTree> Parse(std::string_view bytes);
  std::string Bytes() const;

  const std::vector<CellNode>& nodes() const { return nodes_; }
  const CellNode& root() const { return nodes_.front(); }

  // The cell of a place.
  int32_t CellOf(const Position& p) const {
    int32_t node = 0;
    while (!nodes_[static_cast<size_t>(node)].is_cell()) {
      const CellNode& inner = nodes_[static_cast<size_t>(node)];
      node = inner.children[p[static_cast<size_t>(inner.axis)] < inner.cut ? 0 : 1];
    }
    return node;
  }

  // Takes note of a point of a cell.
  void Count(int32_t cell, const Position& p) {
    CellNode& node = nodes_[static_cast<size_t>(cell)];
    ++node.count;
    node.box.Add(p);
  }

  // Ends the counting: sets `first` of all nodes, and count and box of those above the cells; makes tiles of the
  // largest parts that hold at most `most_points`, and are not longer than `most_extent` on any axis, or of cells,
  // which are not divided. Returns how many.
  int32_t MakeTiles(uint64_t most_points, double most_extent);

  // Calls visit(cell) for each cell within `distance` of a place (or box), the points of its box being meant.
  template <typename Place, typename Visit>
  void ForEachNear(const Place& place, double distance, const Visit& visit) const {
    VisitNear(0, place, distance, visit);
  }

  // The nodes of the tiles, by number.
  std::vector<int32_t> TileNodes() const;

  // A radius within which a place has `count` points of the cloud for sure: the smallest that encloses cells with so
  // many. Infinite if the cloud has fewer.
  double RadiusOf(const Position& p, uint64_t count) const;

 private:
  class Divider;
  void SumUp(int32_t node, uint64_t& first);
  void MakeTilesBelow(int32_t node, uint64_t most_points, double most_extent, int32_t& tiles);

  class Checker;
  struct Enclosed;
  void Enclose(int32_t node, const Position& p, uint64_t count, Enclosed& enclosed) const;

  template <typename Place, typename Visit>
  void VisitNear(int32_t node, const Place& place, double distance, const Visit& visit) const {
    const CellNode& at = nodes_[static_cast<size_t>(node)];
    if (at.count == 0 || !(at.box.DistanceTo(place) <= distance)) return;
    if (at.is_cell()) {
      visit(node);
      return;
    }
    for (const int32_t child : at.children) VisitNear(child, place, distance, visit);
  }

  std::vector<CellNode> nodes_;
};

}  // namespace curv
