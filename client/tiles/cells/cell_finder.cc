#include "client/tiles/cells/cell_finder.h"

#include <array>
#include <limits>

namespace curv {

CellFinder::CellFinder(const CellTree& tree) {
  cuts_.reserve(tree.nodes().size());
  for (const CellNode& node : tree.nodes()) {
    if (node.is_cell()) {
      const auto self = static_cast<int32_t>(cuts_.size());
      cuts_.push_back({-std::numeric_limits<double>::infinity(), 0, self});
    } else {
      cuts_.push_back({node.cut, node.axis, node.children[1]});
    }
  }
}

template <size_t kPoints>
void CellFinder::FindSome(const TilePoint* points, int32_t* cells) const {
  std::array<int32_t, kPoints> at{};
  for (bool moves = true; moves;) {
    int32_t moved = 0;
    for (size_t i = 0; i < kPoints; ++i) {
      const Cut& cut = cuts_[static_cast<size_t>(at[i])];
      // A mask in place of a branch, which would be guessed wrong half the time.
      const int32_t below = -int32_t{points[i].position[static_cast<size_t>(cut.axis)] < cut.at};
      const int32_t next = cut.upper ^ ((cut.upper ^ (at[i] + 1)) & below);
      moved |= next ^ at[i];
      at[i] = next;
    }
    moves = moved != 0;
  }
  for (size_t i = 0; i < kPoints; ++i) cells[i] = at[i];
}

void CellFinder::Find(std::span<const TilePoint> points, std::span<int32_t> cells) const {
  constexpr size_t kAtOnce = 8;
  size_t i = 0;
  for (; i + kAtOnce <= points.size(); i += kAtOnce) FindSome<kAtOnce>(&points[i], &cells[i]);
  for (; i < points.size(); ++i) FindSome<1>(&points[i], &cells[i]);
}

}  // namespace curv
