#include "client/tiles/points/tile_cloud.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "absl/status/status.h"
#include "client/tiles/lattice.h"

namespace curv {
namespace {

// Where a cell has fewer points for each ball that touches it, most are in balls: none is looked for then.
constexpr size_t kPointsABall = 16;

const CellNode& NodeAt(const TilePlan& plan, int32_t node) { return plan.tree.nodes()[static_cast<size_t>(node)]; }

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
  std::vector<Ball> near;
  for (const int32_t cell : CellsOf(store.plan(), balls)) {
    const CellNode& at = NodeAt(store.plan(), cell);
    points.clear();
    if (absl::Status status = store.Append(at.first, at.count, points); !status.ok()) return status;
    near.clear();
    std::copy_if(balls.begin(), balls.end(), std::back_inserter(near),
                 [&](const Ball& ball) { return at.box.DistanceTo(ball.point.position) <= ball.distance; });
    const bool are_few = near.size() <= points.size() / kPointsABall;
    std::copy_if(points.begin(), points.end(), std::back_inserter(cloud.points), [&](const TilePoint& point) {
      // A cell may be long, where one of its points is far from the others.
      if (box.DistanceTo(point.position) > 0.0) return false;
      return !are_few || std::any_of(near.begin(), near.end(), [&](const Ball& ball) {
        return Box{point.position, point.position}.DistanceTo(ball.point.position) <= ball.distance;
      });
    });
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
