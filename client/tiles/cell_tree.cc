#include "client/tiles/cell_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/tiles/cells/neighbor_edges.h"

namespace curv {
namespace {

static_assert(std::is_trivially_copyable_v<CellNode>);

constexpr int kMostDepth = 200;
// Enough that the neighbors which a cut through a tile parts are counted to an eighth or so.
constexpr uint64_t kEdgePointsInTile = 512;

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

// Makes the nodes of a tree.
class CellTree::Divider {
 public:
  Divider(const Parts& parts, std::vector<CellNode>& nodes) : parts_(parts), nodes_(nodes) {}

  void Divide(std::span<Position> sample) {
    sample_ = sample.size();
    const uint64_t edge_points =
        std::min<uint64_t>({sample.size(), kEdgePointsInTile * parts_.tiles, parts_.most_edge_points});
    std::vector<NeighborEdge> edges;
    if (parts_.tiles > 1 || IsTooLong(BoxAround(sample))) edges = EdgesOfNeighbors(sample.first(edge_points));
    DivideTiles(sample, edges, parts_.tiles, 0);
  }

 private:
  struct Cut {
    size_t axis = 0;
    double at = 0.0;
    size_t below = 0;  // points of the sample
  };

  bool IsTooLong(const Box& box) const { return box.Extent(box.LongestAxis()) > parts_.most_extent; }

  // How many parts of a box are short enough on an axis. A box of a few points is shorter than that of all.
  uint64_t PartsOf(const Box& box, size_t axis) const {
    constexpr double kMostParts = 0x1p40;  // a far outlier may make them more than a number holds
    return static_cast<uint64_t>(
        std::ceil(std::min(box.Extent(axis) / parts_.most_extent * (1.0 + 1.0 / 64.0), kMostParts)));
  }

  static size_t CountBelow(std::span<const Position> sample, size_t axis, double at) {
    return static_cast<size_t>(
        std::count_if(sample.begin(), sample.end(), [&](const Position& p) { return p[axis] < at; }));
  }

  // Cuts what is of several tiles, or too long.
  int32_t DivideTiles(std::span<Position> sample, std::span<NeighborEdge> edges, uint64_t tiles, int depth) {
    const Box box = BoxAround(sample);
    const bool is_divided = tiles > 1 || IsTooLong(box);
    if (!is_divided || sample.size() < 2 || !(box.Extent(box.LongestAxis()) > 0.0) || depth == kMostDepth) {
      return DivideCells(sample, CellsOf(sample.size()), depth);
    }
    const Cut cut = BestCut(sample, edges, box, tiles);
    const auto node = static_cast<int32_t>(nodes_.size());
    nodes_.emplace_back();
    std::partition(sample.begin(), sample.end(), [&](const Position& p) { return p[cut.axis] < cut.at; });
    const auto whole = std::partition(edges.begin(), edges.end(),
                                      [&](const NeighborEdge& edge) { return !edge.IsCut(cut.axis, cut.at); });
    const auto above =
        std::partition(edges.begin(), whole, [&](const NeighborEdge& edge) { return edge.a[cut.axis] < cut.at; });
    const uint64_t tiles_below = tiles > 1 ? ShareOf(tiles, cut.below, sample.size()) : 1;
    const int32_t low = DivideTiles(sample.first(cut.below), {edges.begin(), above}, tiles_below, depth + 1);
    const int32_t high =
        DivideTiles(sample.subspan(cut.below), {above, whole}, tiles > 1 ? tiles - tiles_below : 1, depth + 1);
    SetCut(node, cut, low, high);
    return node;
  }

  // The cut that parts the fewest neighbors: between so many tiles, or in the middle of what is too long.
  Cut BestCut(std::span<Position> sample, std::span<const NeighborEdge> edges, const Box& box, uint64_t tiles) const {
    Cut best;
    uint64_t fewest = 0;
    std::array<size_t, 3> axes = {0, 1, 2};  // the longest first, which is taken where others are not better
    std::sort(axes.begin(), axes.end(), [&](size_t a, size_t b) { return box.Extent(a) > box.Extent(b); });
    for (const size_t axis : axes) {
      if (!(box.Extent(axis) > 0.0) || (tiles == 1 && box.Extent(axis) <= parts_.most_extent)) continue;
      Cut cut{.axis = axis};
      if (tiles > 1) {
        cut.at = CutAt(sample, axis, sample.size() * (tiles / 2) / tiles);
      } else {
        const uint64_t parts = std::max<uint64_t>(PartsOf(box, axis), 2), below = parts / 2;
        cut.at = box.low[axis] + box.Extent(axis) * static_cast<double>(below) / static_cast<double>(parts);
      }
      cut.below = CountBelow(sample, axis, cut.at);
      const auto parted = static_cast<uint64_t>(std::count_if(
          edges.begin(), edges.end(), [&](const NeighborEdge& edge) { return edge.IsCut(axis, cut.at); }));
      if (best.below == 0 || parted < fewest) {
        best = cut;
        fewest = parted;
      }
    }
    return best;
  }

  // The cells of a tile with so many points of the sample.
  uint64_t CellsOf(size_t points) const {
    return std::max<uint64_t>(points * parts_.tiles * parts_.cells_per_tile / sample_, 1);
  }

  int32_t DivideCells(std::span<Position> sample, uint64_t cells, int depth) {
    const auto node = static_cast<int32_t>(nodes_.size());
    nodes_.emplace_back();
    const Box box = BoxAround(sample);
    Cut cut{.axis = box.LongestAxis()};
    if (cells <= 1 || sample.size() < 2 || !(box.Extent(cut.axis) > 0.0) || depth == kMostDepth) return node;
    cut.at = CutAt(sample, cut.axis, sample.size() * (cells / 2) / cells);
    cut.below = CountBelow(sample, cut.axis, cut.at);
    const uint64_t cells_below = ShareOf(cells, cut.below, sample.size());
    const int32_t low = DivideCells(sample.first(cut.below), cells_below, depth + 1);
    const int32_t high = DivideCells(sample.subspan(cut.below), cells - cells_below, depth + 1);
    SetCut(node, cut, low, high);
    return node;
  }

  void SetCut(int32_t node, const Cut& cut, int32_t low, int32_t high) {
    CellNode& made = nodes_[static_cast<size_t>(node)];
    made.children = {low, high};
    made.axis = static_cast<int32_t>(cut.axis);
    made.cut = cut.at;
  }

  const Parts& parts_;
  std::vector<CellNode>& nodes_;
  size_t sample_ = 0;  // points
};

CellTree CellTree::Divide(std::vector<Position> sample, const Parts& parts) {
  CellTree tree;
  Divider(parts, tree.nodes_).Divide(sample);
  return tree;
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
