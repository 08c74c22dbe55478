#include "client/tiles/tile_cloud.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "client/tiles/lattice.h"

namespace curv {
namespace {

// The area of a piece of surface that fills a box: that of its largest side.
double SurfaceIn(const Box& box) {
  std::array<double, 3> extents = {box.Extent(0), box.Extent(1), box.Extent(2)};
  std::sort(extents.begin(), extents.end());
  return extents[1] * extents[2];
}

const CellNode& NodeAt(const TilePlan& plan, int32_t node) { return plan.tree.nodes()[static_cast<size_t>(node)]; }

bool IsOf(const CellNode& cell, const CellNode& tile) {
  return cell.first >= tile.first && cell.first < tile.first + tile.count;
}

// How wide a halo may be before a tile is too long for floats.
double WidestHalo(const TilePlan& plan, const Box& box) {
  if (!plan.is_double) return std::numeric_limits<double>::infinity();
  const double longest = 2.0 * (kMostSteps - 1.0) * plan.spacing;
  return std::max(0.0, (longest - box.Extent(box.LongestAxis())) / 2.0);
}

// Keeps the cells nearest to a tile, so that the halo is no longer than a few tiles: a point far from all others makes
// its cell look sparse, and its neighborhood large.
void DropFarthest(const TilePlan& plan, const CellNode& own, std::vector<CellShare>& shares) {
  constexpr uint64_t kMostTiles = 4;
  uint64_t points = 0;
  for (const CellShare& share : shares) points += NodeAt(plan, share.cell).count;
  const uint64_t most = kMostTiles * std::max(own.count, plan.tile_points);
  if (points <= most) return;
  std::stable_sort(shares.begin(), shares.end(), [&](const CellShare& a, const CellShare& b) {
    return NodeAt(plan, a.cell).box.DistanceTo(own.box) < NodeAt(plan, b.cell).box.DistanceTo(own.box);
  });
  while (points > most) {
    points -= NodeAt(plan, shares.back().cell).count;
    shares.pop_back();
  }
  std::sort(shares.begin(), shares.end(), [](const CellShare& a, const CellShare& b) { return a.cell < b.cell; });
}

// The cells around a tile that have points in its halo, ascending, and how wide it is there. Wide enough for what both
// the cell and the tile's cells near it expect: density may change between them.
std::vector<CellShare> HaloCells(const PointStore& store, size_t tile, double factor) {
  const TilePlan& plan = store.plan();
  const CellNode& own = plan.tile(tile);
  const auto radius_of = [&](int32_t cell) { return store.expected_radii()[static_cast<size_t>(cell)]; };
  std::vector<int32_t> inner;
  double widest = 0.0;
  for (int32_t node = plan.tiles[tile]; static_cast<size_t>(node) < plan.tree.nodes().size(); ++node) {
    const CellNode& at = NodeAt(plan, node);
    if (at.first >= own.first + own.count) break;
    if (!at.is_cell() || at.count == 0) continue;
    inner.push_back(node);
    widest = std::max(widest, radius_of(node));
  }
  const double limit = WidestHalo(plan, own.box);
  std::vector<CellShare> shares;
  plan.tree.ForEachNear(own.box, 2.0 * factor * widest, [&](int32_t cell) {
    const CellNode& at = NodeAt(plan, cell);
    if (IsOf(at, own)) return;
    double radius = std::min(radius_of(cell), 2.0 * widest);
    for (const int32_t near : inner) {
      if (radius_of(near) <= radius) continue;
      if (NodeAt(plan, near).box.DistanceTo(at.box) <= factor * radius_of(near)) radius = radius_of(near);
    }
    const double width = std::min(factor * radius, limit);
    if (at.box.DistanceTo(own.box) < width) shares.push_back({cell, width, false});
  });
  DropFarthest(plan, own, shares);
  return shares;
}

void SortById(std::vector<TilePoint>& points) {
  std::sort(points.begin(), points.end(), [](const TilePoint& a, const TilePoint& b) { return a.id < b.id; });
}

// The cells that balls touch, ascending, each once.
std::vector<int32_t> CellsOf(const TilePlan& plan, std::span<const Ball> balls) {
  std::vector<int32_t> cells;
  for (const Ball& ball : balls) {
    plan.tree.ForEachNear(ball.point.position, ball.distance, [&](int32_t cell) { cells.push_back(cell); });
    if (cells.size() < 4 * plan.tree.nodes().size()) continue;
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace

PointStore::PointStore(const TilePlan& plan, InputFile file) : plan_(plan), file_(std::move(file)) {
  const Box& box = plan.tree.root().box;
  expected_radii_.resize(plan.tree.nodes().size());
  ExpectRadius(0, plan.reach.Around(plan.reach.neighbor_count == 0 ? plan.reach.radius : box.FarDistanceTo(box.low)));
}

void PointStore::ExpectRadius(int32_t node, double radius) {
  const CellNode& at = NodeAt(plan_, node);
  const uint64_t neighbors = plan_.reach.neighbor_count;
  if (neighbors > 0 && at.count >= 2 * neighbors) {
    const double share = static_cast<double>(neighbors) / static_cast<double>(at.count);
    radius = plan_.reach.Around(std::sqrt(share * SurfaceIn(at.box) / std::numbers::pi));
  }
  expected_radii_[static_cast<size_t>(node)] = radius;
  if (at.is_cell()) return;
  for (const int32_t child : at.children) ExpectRadius(child, radius);
}

absl::StatusOr<PointStore> PointStore::Open(const TilePlan& plan) {
  absl::StatusOr<InputFile> file = InputFile::Open(plan.PathOf("points.bin"));
  if (!file.ok()) return absl::FailedPreconditionError(file.status().message());
  return PointStore(plan, *std::move(file));
}

absl::Status PointStore::Append(uint64_t first, uint64_t count, std::vector<TilePoint>& points) const {
  constexpr uint64_t kPointsAtATime = 1 << 16;
  const size_t bytes = StoredBytes(plan_.is_double);
  std::string read;
  for (uint64_t done = 0; done < count;) {
    const uint64_t now = std::min(kPointsAtATime, count - done);
    read.resize(now * bytes);
    if (absl::Status status = file_.ReadAll((first + done) * bytes, read.size(), read.data()); !status.ok()) {
      return absl::FailedPreconditionError(status.message());
    }
    for (uint64_t i = 0; i < now; ++i) points.push_back(UnpackPoint(read.data() + i * bytes, plan_.is_double));
    done += now;
  }
  return absl::OkStatus();
}

bool FitsFloats(const TilePlan& plan, const Box& box) {
  return !plan.is_double || SpacingFor(box.Extent(box.LongestAxis()), plan.spacing) == plan.spacing;
}

FloatArrays ToFloats(const TilePlan& plan, const TileCloud& cloud) {
  FloatArrays arrays;
  Position origin{};
  double coarse = 0.0;
  if (plan.is_double) {
    Box box;
    for (const TilePoint& point : cloud.points) box.Add(point.position);
    const double spacing = SpacingFor(box.Extent(box.LongestAxis()), plan.spacing);
    if (spacing > plan.spacing) coarse = spacing;
    arrays.spacing = spacing;
    for (size_t axis = 0; axis < 3; ++axis) {
      origin[axis] = OnLattice(box.low[axis] + box.Extent(axis) / 2.0, spacing);
    }
  }
  arrays.coarse_spacing = coarse;
  arrays.positions.reserve(3 * cloud.points.size());
  arrays.normals.reserve(3 * cloud.points.size());
  arrays.ids.reserve(cloud.points.size());
  for (const TilePoint& point : cloud.points) {
    arrays.ids.push_back(point.id);
    for (size_t axis = 0; axis < 3; ++axis) {
      double coordinate = point.position[axis] - origin[axis];
      if (coarse > 0.0) coordinate = OnLattice(coordinate, coarse);
      arrays.positions.push_back(static_cast<float>(coordinate));
      arrays.normals.push_back(point.normal[axis]);
    }
  }
  return arrays;
}

absl::StatusOr<TileWithHalo> ReadTile(const PointStore& store, size_t tile, double factor) {
  const TilePlan& plan = store.plan();
  const CellNode& own = plan.tile(tile);
  TileWithHalo read{.cloud = {}, .box = own.box, .shares = HaloCells(store, tile, factor)};
  std::vector<TilePoint>& points = read.cloud.points;
  points.reserve(own.count + own.count / 8);
  if (absl::Status status = store.Append(own.first, own.count, points); !status.ok()) return status;
  std::vector<TilePoint> others;
  for (CellShare& share : read.shares) {
    const CellNode& cell = NodeAt(plan, share.cell);
    others.clear();
    if (absl::Status status = store.Append(cell.first, cell.count, others); !status.ok()) return status;
    const size_t before = points.size();
    for (const TilePoint& point : others) {
      if (own.box.DistanceTo(point.position) < share.width) points.push_back(point);
    }
    share.is_whole = points.size() - before == others.size();
  }
  std::vector<uint64_t> ids;
  ids.reserve(own.count);
  for (uint64_t i = 0; i < own.count; ++i) ids.push_back(points[i].id);
  std::sort(ids.begin(), ids.end());
  SortById(points);
  read.cloud.queries.reserve(own.count);
  size_t next = 0;
  for (size_t i = 0; i < points.size() && next < ids.size(); ++i) {
    if (points[i].id != ids[next]) continue;
    read.cloud.queries.push_back(static_cast<uint32_t>(i));
    ++next;
  }
  return read;
}

bool HasAllWithin(const TilePlan& plan, size_t tile, const TileWithHalo& read, const Position& p, double distance) {
  const CellNode& own = plan.tile(tile);
  const double depth = std::max(read.box.DepthOf(p), 0.0);
  if (distance < depth) return true;
  bool has_all = true;
  plan.tree.ForEachNear(p, distance, [&](int32_t cell) {
    const CellNode& at = NodeAt(plan, cell);
    if (!has_all || IsOf(at, own)) return;
    const auto share = std::lower_bound(read.shares.begin(), read.shares.end(), cell,
                                        [](const CellShare& a, int32_t b) { return a.cell < b; });
    const bool is_here = share != read.shares.end() && share->cell == cell;
    if (is_here && share->is_whole) return;
    // What was left out is at least as far from the box as the halo is wide, and the box ends `depth` from here.
    has_all = is_here && distance < share->width + depth;
  });
  return has_all;
}

Box BoxAround(std::span<const Ball> balls) {
  Box box;
  for (const Ball& ball : balls) {
    for (const double sign : {-1.0, 1.0}) {
      const Position& p = ball.point.position;
      box.Add(Position{p[0] + sign * ball.distance, p[1] + sign * ball.distance, p[2] + sign * ball.distance});
    }
  }
  return box;
}

uint64_t CountBalls(const TilePlan& plan, std::span<const Ball> balls) {
  uint64_t count = 0;
  for (const int32_t cell : CellsOf(plan, balls)) count += NodeAt(plan, cell).count;
  return count;
}

absl::StatusOr<TileCloud> ReadBalls(const PointStore& store, std::span<const Ball> balls) {
  TileCloud cloud;
  const Box box = BoxAround(balls);
  std::vector<TilePoint> points;
  for (const int32_t cell : CellsOf(store.plan(), balls)) {
    const CellNode& at = NodeAt(store.plan(), cell);
    points.clear();
    if (absl::Status status = store.Append(at.first, at.count, points); !status.ok()) return status;
    // A cell may be long, where one of its points is far from the others.
    std::copy_if(points.begin(), points.end(), std::back_inserter(cloud.points),
                 [&](const TilePoint& point) { return box.DistanceTo(point.position) == 0.0; });
  }
  SortById(cloud.points);
  for (const Ball& ball : balls) {
    const auto found = std::lower_bound(cloud.points.begin(), cloud.points.end(), ball.point.id,
                                        [](const TilePoint& point, uint64_t id) { return point.id < id; });
    cloud.queries.push_back(static_cast<uint32_t>(found - cloud.points.begin()));
  }
  std::sort(cloud.queries.begin(), cloud.queries.end());
  return cloud;
}

}  // namespace curv
