// Finds the cells of many points at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/tiles/cell_tree.h"
#include "client/tiles/tile_point.h"

namespace curv {

// The cuts of a tree, as small as they can be. Points go down the tree several at a time: the processor waits neither
// for the memory of one, nor for the way that it takes. Thread-safe.
class CellFinder {
 public:
  explicit CellFinder(const CellTree& tree);

  // Sets cells[i] to what CellOf says of points[i]. REQUIRES: cells.size() == points.size(); positions are finite.
  void Find(std::span<const TilePoint> points, std::span<int32_t> cells) const;

 private:
  // What is below a cut is the next node. A cell is its own upper child, with nothing below its cut.
  struct Cut {
    double at;
    int32_t axis;
    int32_t upper;
  };

  template <size_t kPoints>
  void FindSome(const TilePoint* points, int32_t* cells) const;

  std::vector<Cut> cuts_;  // of each node
};

}  // namespace curv
