#include "client/tiles/cell_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace curv {
namespace {

static_assert(std::is_trivially_copyable_v<CellNode>);

constexpr int kMostDepth = 200;

Box BoxAround(std::span<const Position> points) {
  Box box;
  for (const Position& p : points) box.Add(p);
  return box;
}

// Moves points with coordinates below the returned cut to the front. The cut is near the place `middle`, and leaves
// something on both sides. REQUIRES: the coordinates are not all the same.
double CutAt(std::span<Position> points, size_t axis, size_t middle) {
  const auto less = [axis](const Position& a, const Position& b) { return a[axis] < b[axis]; };
  const auto at = points.begin() + static_cast<ptrdiff_t>(middle);
  std::nth_element(points.begin(), at, points.end(), less);
  double cut = (*at)[axis];
  if ((*std::min_element(points.begin(), points.end(), less))[axis] == cut) {
    double next = std::numeric_limits<double>::infinity();
    for (const Position& p : points) {
      if (p[axis] > cut) next = std::min(next, p[axis]);
    }
    cut = next;
  }
  std::partition(points.begin(), points.end(), [&](const Position& p) { return p[axis] < cut; });
  return cut;
}

// The share of `parts` that goes with `part` of `whole` points: at least one, and at most all but one.
uint64_t ShareOf(uint64_t parts, size_t part, size_t whole) {
  const double share = static_cast<double>(parts) * static_cast<double>(part) / static_cast<double>(whole);
  return std::clamp<uint64_t>(static_cast<uint64_t>(std::llround(share)), 1, parts - 1);
}

}  // namespace

CellTree CellTree::Divide(std::vector<Position> sample, uint64_t tiles, uint64_t cells_per_tile) {
  CellTree tree;
  tree.DivideRange(sample, tiles, cells_per_tile, 0);
  return tree;
}

int32_t CellTree::DivideRange(std::span<Position> sample, uint64_t tiles, uint64_t cells_per_tile, int depth) {
  const auto node = static_cast<int32_t>(nodes_.size());
  nodes_.emplace_back();
  const uint64_t parts = tiles > 1 ? tiles : cells_per_tile;
  const Box box = BoxAround(sample);
  const size_t axis = box.LongestAxis();
  if (parts <= 1 || sample.size() < 2 || !(box.Extent(axis) > 0.0) || depth == kMostDepth) return node;
  const double cut = CutAt(sample, axis, sample.size() * (parts / 2) / parts);
  const auto lower = static_cast<size_t>(
      std::partition_point(sample.begin(), sample.end(), [&](const Position& p) { return p[axis] < cut; }) -
      sample.begin());
  const uint64_t below = ShareOf(parts, lower, sample.size());
  const auto divide = [&](std::span<Position> side, uint64_t side_parts) {
    return tiles > 1 ? DivideRange(side, side_parts, cells_per_tile, depth + 1)
                     : DivideRange(side, 1, side_parts, depth + 1);
  };
  const int32_t low = divide(sample.first(lower), below);
  const int32_t high = divide(sample.subspan(lower), parts - below);
  CellNode& made = nodes_[static_cast<size_t>(node)];
  made.children = {low, high};
  made.axis = static_cast<int32_t>(axis);
  made.cut = cut;
  return node;
}

int32_t CellTree::MakeTiles(uint64_t most_points, double most_extent) {
  uint64_t first = 0;
  SumUp(0, first);
  int32_t tiles = 0;
  MakeTilesBelow(0, most_points, most_extent, tiles);
  return tiles;
}

void CellTree::SumUp(int32_t node, uint64_t& first) {
  CellNode& at = nodes_[static_cast<size_t>(node)];
  at.first = first;
  if (at.is_cell()) {
    first += at.count;
    return;
  }
  at.count = 0;
  for (const int32_t child : at.children) {
    SumUp(child, first);
    at.count += nodes_[static_cast<size_t>(child)].count;
    at.box.Add(nodes_[static_cast<size_t>(child)].box);
  }
}

void CellTree::MakeTilesBelow(int32_t node, uint64_t most_points, double most_extent, int32_t& tiles) {
  CellNode& at = nodes_[static_cast<size_t>(node)];
  if (at.count == 0) return;
  if (at.is_cell() || (at.count <= most_points && at.box.Extent(at.box.LongestAxis()) <= most_extent)) {
    at.tile = tiles++;
    return;
  }
  for (const int32_t child : at.children) MakeTilesBelow(child, most_points, most_extent, tiles);
}

std::vector<int32_t> CellTree::TileNodes() const {
  std::vector<int32_t> tiles;
  for (size_t node = 0; node < nodes_.size(); ++node) {
    if (nodes_[node].tile >= 0) tiles.push_back(static_cast<int32_t>(node));
  }
  return tiles;
}

// Cells, and how far it is to the farthest place of each: the nearest that hold enough points together.
struct CellTree::Enclosed {
  std::multimap<double, uint64_t> cells;  // points by distance
  uint64_t points = 0;
  double radius = std::numeric_limits<double>::infinity();
};

void CellTree::Enclose(int32_t node, const Position& p, uint64_t count, Enclosed& enclosed) const {
  const CellNode& at = nodes_[static_cast<size_t>(node)];
  if (at.count == 0 || at.box.DistanceTo(p) > enclosed.radius) return;
  if (!at.is_cell()) {
    const auto [low, high] = at.children;
    const bool low_first =
        nodes_[static_cast<size_t>(low)].box.DistanceTo(p) <= nodes_[static_cast<size_t>(high)].box.DistanceTo(p);
    Enclose(low_first ? low : high, p, count, enclosed);
    Enclose(low_first ? high : low, p, count, enclosed);
    return;
  }
  enclosed.cells.emplace(at.box.FarDistanceTo(p), at.count);
  enclosed.points += at.count;
  while (enclosed.points - std::prev(enclosed.cells.end())->second >= count) {
    enclosed.points -= std::prev(enclosed.cells.end())->second;
    enclosed.cells.erase(std::prev(enclosed.cells.end()));
  }
  if (enclosed.points >= count) enclosed.radius = std::prev(enclosed.cells.end())->first;
}

double CellTree::RadiusOf(const Position& p, uint64_t count) const {
  Enclosed enclosed;
  Enclose(0, p, std::max<uint64_t>(count, 1), enclosed);
  return enclosed.radius;
}

std::string CellTree::Bytes() const {
  return {reinterpret_cast<const char*>(nodes_.data()), nodes_.size() * sizeof(CellNode)};
}

// Looks whether nodes are those of a tree, in their order.
class CellTree::Checker {
 public:
  explicit Checker(std::span<const CellNode> nodes) : nodes_(nodes) {}

  absl::Status Check() {
    if (!CheckBelow(0, 0, false) || next_ != nodes_.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("node ", std::min(next_, nodes_.size()), " of the cells is none that a plan has"));
    }
    return absl::OkStatus();
  }

 private:
  // Goes through a node and all below, and then on to `next_`. False: a node is wrong; it is `next_`, or one before.
  bool CheckBelow(size_t node, int depth, bool in_tile) {
    const CellNode& at = nodes_[node];
    if (depth > kMostDepth || at.axis < 0 || at.axis > 2 || at.first != first_ || !HasBox(at)) return false;
    if (at.tile != -1 && (in_tile || at.count == 0 || at.tile != tiles_++)) return false;
    in_tile = in_tile || at.tile != -1;
    ++next_;
    if (at.is_cell()) {
      first_ += at.count;
      // Either all points are in tiles, or no tiles were made yet.
      if (at.count > 0 && !in_tile) ++outside_;
      return at.children[0] == -1 && at.children[1] == -1 && at.count <= kMostPoints && first_ <= kMostPoints &&
             (outside_ == 0 || tiles_ == 0);
    }
    Box box;
    for (const int32_t child : at.children) {
      if (child < 0 || static_cast<size_t>(child) != next_ || next_ == nodes_.size()) return false;
      if (!CheckBelow(next_, depth + 1, in_tile)) return false;
      box.Add(nodes_[static_cast<size_t>(child)].box);
    }
    return first_ - at.first == at.count && box.low == at.box.low && box.high == at.box.high;
  }

  static bool HasBox(const CellNode& at) {
    if (at.count == 0) return at.box.empty();
    for (size_t axis = 0; axis < 3; ++axis) {
      const double low = at.box.low[axis], high = at.box.high[axis];
      if (!std::isfinite(low) || !std::isfinite(high) || low > high) return false;
    }
    return true;
  }

  static constexpr uint64_t kMostPoints = uint64_t{1} << 56;  // their bytes can be counted

  const std::span<const CellNode> nodes_;
  size_t next_ = 0;
  uint64_t first_ = 0;
  int32_t tiles_ = 0;
  uint64_t outside_ = 0;
};

absl::StatusOr<CellTree> CellTree::Parse(std::string_view bytes) {
  if (bytes.empty() || bytes.size() % sizeof(CellNode) != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("the cells take ", bytes.size(), " bytes: expected a multiple of ", sizeof(CellNode), ", not 0"));
  }
  CellTree tree;
  tree.nodes_.resize(bytes.size() / sizeof(CellNode));
  std::memcpy(tree.nodes_.data(), bytes.data(), bytes.size());
  if (absl::Status status = Checker(tree.nodes_).Check(); !status.ok()) return status;
  return tree;
}

}  // namespace curv
