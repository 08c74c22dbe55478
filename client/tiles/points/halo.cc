#include "client/tiles/points/halo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "client/tiles/lattice.h"

namespace curv {
namespace {

const CellNode& NodeAt(const TilePlan& plan, int32_t node) { return plan.tree.nodes()[static_cast<size_t>(node)]; }

bool IsOf(const CellNode& cell, const CellNode& tile) {
  return cell.first >= tile.first && cell.first < tile.first + tile.count;
}

double SquareBetween(const Position& a, const Position& b) {
  double sum = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
  return sum;
}

// How wide a halo may be before a tile is too long for floats.
double WidestHalo(const TilePlan& plan, const Box& box) {
  if (!plan.is_double) return std::numeric_limits<double>::infinity();
  const double longest = 2.0 * (kMostSteps - 1.0) * plan.spacing;
  return std::max(0.0, (longest - box.Extent(box.LongestAxis())) / 2.0);
}

// The radius of neighborhoods in a cell. Some of its points find theirs in the cell alone. Of those at its rim, which
// find too large ones, there are so few among them that the second smallest is of none; and a single pair of points
// that coincide does not count. REQUIRES: there are more points than `neighbors`.
double MeasureRadius(std::span<const TilePoint> points, uint64_t neighbors) {
  constexpr size_t kMeasured = 6;
  std::array<double, kMeasured> squares{};
  std::vector<double> to_others(points.size());
  for (size_t i = 0; i < kMeasured; ++i) {
    const Position& at = points[i * points.size() / kMeasured].position;
    for (size_t j = 0; j < points.size(); ++j) to_others[j] = SquareBetween(at, points[j].position);
    const auto kth = to_others.begin() + static_cast<ptrdiff_t>(neighbors - 1);
    std::nth_element(to_others.begin(), kth, to_others.end());
    squares[i] = *kth;
  }
  std::sort(squares.begin(), squares.end());
  return std::sqrt(squares[1]);
}

// Finds boxes around a few near points each, which together hold all points that are nearer than `width` to one of the
// other boxes.
class PieceFinder {
 public:
  PieceFinder(std::span<const Box> others, double width) : others_(others), width_(width) {}

  // Changes the order of the points.
  std::vector<Box> Find(std::span<Position> points) {
    FindAmong(points);
    return std::move(pieces_);
  }

 private:
  static constexpr size_t kPointsInPiece = 16;  // about as long as a halo is wide, so that it is hardly wider for them

  void FindAmong(std::span<Position> points) {
    Box box;
    for (const Position& p : points) box.Add(p);
    if (std::none_of(others_.begin(), others_.end(), [&](const Box& o) { return o.DistanceTo(box) < width_; })) return;
    if (points.size() <= kPointsInPiece) {
      pieces_.push_back(box);
      return;
    }
    const size_t axis = box.LongestAxis(), half = points.size() / 2;
    std::nth_element(points.begin(), points.begin() + static_cast<ptrdiff_t>(half), points.end(),
                     [axis](const Position& a, const Position& b) { return a[axis] < b[axis]; });
    FindAmong(points.first(half));
    FindAmong(points.subspan(half));
  }

  const std::span<const Box> others_;
  const double width_;
  std::vector<Box> pieces_;
};

// Finds out which points go along with a tile.
class HaloReader {
 public:
  HaloReader(const PointStore& store, size_t tile, double factor)
      : store_(store), plan_(store.plan()), root_(plan_.tiles[tile]), own_(NodeAt(plan_, root_)), factor_(factor) {}

  absl::StatusOr<TileWithHalo> Read() {
    points_.reserve(own_.count + own_.count / 8);
    if (absl::Status status = store_.Append(own_.first, own_.count, points_); !status.ok()) return status;
    FindOwnCells();
    FindPairs();
    DropFarthest();
    if (absl::Status status = ReadAround(); !status.ok()) return status;
    Order();
    return std::move(result_);
  }

 private:
  // A cell of the tile, and one of another tile that is nearer to it than its halo is wide.
  struct Pair {
    int32_t other;
    uint32_t own;
  };

  const CellNode& OwnAt(uint32_t own) const { return NodeAt(plan_, result_.own[own].cell); }

  // REQUIRES: it is one of the tile's cells.
  std::span<const TilePoint> PointsOf(const CellNode& cell) const {
    return std::span(points_).subspan(cell.first - own_.first, cell.count);
  }

  void FindOwnCells() {
    for (int32_t node = root_; static_cast<size_t>(node) < plan_.tree.nodes().size(); ++node) {
      const CellNode& at = NodeAt(plan_, node);
      if (at.first >= own_.first + own_.count) break;
      if (at.is_cell() && at.count > 0) result_.own.push_back({node, 0.0});
    }
  }

  double WidthOf(int32_t cell) const {
    const double expected = store_.expected_radii()[static_cast<size_t>(cell)];
    const CellNode& at = NodeAt(plan_, cell);
    const uint64_t neighbors = plan_.reach.neighbor_count;
    if (neighbors == 0) return expected * std::min(factor_, 1.0 + 1e-9);
    if (at.count < 2 * neighbors) return expected * factor_;
    return plan_.reach.Around(MeasureRadius(PointsOf(at), neighbors)) * factor_;
  }

  void FindPairs() {
    const double limit = WidestHalo(plan_, own_.box);
    pieces_.resize(result_.own.size());
    for (uint32_t own = 0; own < result_.own.size(); ++own) {
      const int32_t cell = result_.own[own].cell;
      // Twice as far as the box of a cell makes one expect, no halo goes. Most cells have no other tile so near.
      double width = std::min(2.0 * factor_ * store_.expected_radii()[static_cast<size_t>(cell)], limit);
      std::vector<std::pair<double, int32_t>> others;
      plan_.tree.ForEachNear(OwnAt(own).box, width, [&](int32_t other) {
        if (IsOf(NodeAt(plan_, other), own_)) return;
        others.emplace_back(OwnAt(own).box.DistanceTo(NodeAt(plan_, other).box), other);
      });
      if (!others.empty()) width = std::min(width, WidthOf(cell));
      result_.own[own].width = width;
      for (const auto& [distance, other] : others) {
        if (distance < width) pairs_.push_back({other, own});
      }
      if (!pairs_.empty() && pairs_.back().own == own) FindPieces(own, others);
    }
    std::sort(pairs_.begin(), pairs_.end(),
              [](const Pair& a, const Pair& b) { return std::pair(a.other, a.own) < std::pair(b.other, b.own); });
  }

  // Keeps the cells nearest to the tile, so that not more than a few tiles are read: a point far from all others makes
  // its neighborhood large.
  void DropFarthest() {
    constexpr uint64_t kMostTiles = 4;
    std::vector<std::pair<double, int32_t>> cells;
    uint64_t points = 0;
    for (const Pair& pair : pairs_) {
      if (!cells.empty() && cells.back().second == pair.other) continue;
      cells.emplace_back(NodeAt(plan_, pair.other).box.DistanceTo(own_.box), pair.other);
      points += NodeAt(plan_, pair.other).count;
    }
    const uint64_t most = kMostTiles * std::max(own_.count, plan_.tile_points);
    if (points <= most) return;
    std::sort(cells.begin(), cells.end());
    std::vector<int32_t> dropped;
    for (; points > most; cells.pop_back()) {
      points -= NodeAt(plan_, cells.back().second).count;
      dropped.push_back(cells.back().second);
    }
    std::sort(dropped.begin(), dropped.end());
    std::erase_if(pairs_, [&](const Pair& pair) {
      if (!std::binary_search(dropped.begin(), dropped.end(), pair.other)) return false;
      OwnCell& own = result_.own[pair.own];
      own.width = std::min(own.width, OwnAt(pair.own).box.DistanceTo(NodeAt(plan_, pair.other).box));
      return true;
    });
  }

  absl::Status ReadAround() {
    std::vector<TilePoint> others;
    for (size_t begin = 0, end = 0; begin < pairs_.size(); begin = end) {
      const int32_t cell = pairs_[begin].other;
      while (end < pairs_.size() && pairs_[end].other == cell) ++end;
      others.clear();
      absl::Status status = store_.Append(NodeAt(plan_, cell).first, NodeAt(plan_, cell).count, others);
      if (!status.ok()) return status;
      ReadCell& read = result_.read.emplace_back();
      read.cell = cell;
      const std::vector<Piece> pieces = PiecesNear(std::span(pairs_).subspan(begin, end - begin));
      for (const TilePoint& point : others) {
        if (IsNear(point.position, pieces)) {
          points_.push_back(point);
        } else {
          read.left_out.push_back(point.position);
        }
      }
    }
    return absl::OkStatus();
  }

  // A piece of one of the tile's cells, and its cell's halo.
  struct Piece {
    Box box;
    double width;
  };

  // Finds the pieces of a cell of the tile whose halo reaches other cells.
  void FindPieces(uint32_t own, std::span<const std::pair<double, int32_t>> others) {
    std::vector<Box> boxes;
    for (const auto& [distance, other] : others) {
      if (distance < result_.own[own].width) boxes.push_back(NodeAt(plan_, other).box);
    }
    std::vector<Position> positions;
    positions.reserve(OwnAt(own).count);
    for (const TilePoint& point : PointsOf(OwnAt(own))) positions.push_back(point.position);
    pieces_[own] = PieceFinder(boxes, result_.own[own].width).Find(positions);
  }

  // The pieces whose halo the other cell of these pairs is in. A cell's own box would hold places that its points are
  // not near to, where a surface is not parallel to the axes.
  std::vector<Piece> PiecesNear(std::span<const Pair> pairs) const {
    std::vector<Piece> near;
    for (const Pair& pair : pairs) {
      const double width = result_.own[pair.own].width;
      for (const Box& box : pieces_[pair.own]) {
        if (box.DistanceTo(NodeAt(plan_, pair.other).box) < width) near.push_back({box, width});
      }
    }
    return near;
  }

  static bool IsNear(const Position& p, std::span<const Piece> pieces) {
    return std::any_of(pieces.begin(), pieces.end(),
                       [&](const Piece& piece) { return piece.box.DistanceTo(p) < piece.width; });
  }

  // Puts all points in the order of their ids.
  void Order() {
    std::vector<std::pair<uint64_t, uint32_t>> order;  // ids, and places in points_
    order.reserve(points_.size());
    for (const TilePoint& point : points_) order.emplace_back(point.id, static_cast<uint32_t>(order.size()));
    std::sort(order.begin(), order.end());
    std::vector<uint32_t> cell_of(own_.count);
    for (uint32_t own = 0; own < result_.own.size(); ++own) {
      const auto first = cell_of.begin() + static_cast<ptrdiff_t>(OwnAt(own).first - own_.first);
      std::fill_n(first, OwnAt(own).count, own);
    }
    TileCloud& cloud = result_.cloud;
    cloud.points.reserve(points_.size());
    cloud.queries.reserve(own_.count);
    result_.cells.reserve(own_.count);
    for (const auto& [id, at] : order) {
      if (at < own_.count) {
        cloud.queries.push_back(static_cast<uint32_t>(cloud.points.size()));
        result_.cells.push_back(cell_of[at]);
      }
      cloud.points.push_back(points_[at]);
    }
  }

  const PointStore& store_;
  const TilePlan& plan_;
  const int32_t root_;
  const CellNode& own_;
  const double factor_;
  std::vector<TilePoint> points_;         // those of the tile in the order of the store, and then the halo's
  std::vector<Pair> pairs_;               // ascending by the other cell
  std::vector<std::vector<Box>> pieces_;  // of each of the tile's cells that is in a pair
  TileWithHalo result_;
};

}  // namespace

absl::StatusOr<TileWithHalo> ReadTile(const PointStore& store, size_t tile, double factor) {
  return HaloReader(store, tile, factor).Read();
}

bool HasAllWithin(const TilePlan& plan, const TileWithHalo& tile, size_t query, double distance) {
  // All that was left out is at least so far from each point of the cell.
  if (distance < tile.own[tile.cells[query]].width) return true;
  const Position& p = tile.cloud.points[tile.cloud.queries[query]].position;
  bool has_all = true;
  plan.tree.ForEachNear(p, distance, [&](int32_t cell) {
    if (!has_all) return;
    const auto by_cell = [](const auto& a, int32_t b) { return a.cell < b; };
    const auto own = std::lower_bound(tile.own.begin(), tile.own.end(), cell, by_cell);
    if (own != tile.own.end() && own->cell == cell) return;
    const auto read = std::lower_bound(tile.read.begin(), tile.read.end(), cell, by_cell);
    has_all = read != tile.read.end() && read->cell == cell &&
              std::none_of(read->left_out.begin(), read->left_out.end(),
                           [&](const Position& other) { return SquareBetween(p, other) <= distance * distance; });
  });
  return has_all;
}

}  // namespace curv
