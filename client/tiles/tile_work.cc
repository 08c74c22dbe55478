#include "client/tiles/tile_work.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace curv {
namespace {

constexpr int kMostPasses = 8;
// Positions that are rounded to a coarse lattice are off by a step, relative to which distances are this many.
constexpr double kStepsOff = 4.0;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// One tile at work.
class TileWork {
 public:
  TileWork(const PointStore& store, size_t tile, double halo_factor, const TileEstimator& estimator)
      : store_(store), plan_(store.plan()), tile_(tile), halo_factor_(halo_factor), estimator_(estimator) {
    result_.tile = tile;
  }

  absl::StatusOr<TileResult> Run() {
    const absl::Time start = absl::Now();
    std::vector<Ball> uncertain;
    absl::Status status = EstimateFirst(uncertain);
    result_.uncertain_points = uncertain.size();
    for (int pass = 0; status.ok() && !uncertain.empty(); ++pass) {
      if (pass == kMostPasses) {
        return absl::InternalError(absl::StrCat("tile ", tile_, ": ", uncertain.size(),
                                                " points have larger "
                                                "neighborhoods each time that they are estimated"));
      }
      const std::vector<Ball> balls = std::exchange(uncertain, {});
      status = Repair(balls, uncertain);
    }
    if (!status.ok()) return status;
    const absl::Time end = absl::Now();
    result_.points = ids_.size();
    result_.seconds = absl::ToDoubleSeconds(end - start);
    result_.finished = absl::ToDoubleSeconds(end - absl::UnixEpoch());
    if (status = WriteTileResult(plan_, result_, ids_, columns_); !status.ok()) return status;
    return result_;
  }

 private:
  // Estimates the tile with its halo, and tells of which points that is not certain.
  absl::Status EstimateFirst(std::vector<Ball>& uncertain) {
    const absl::StatusOr<TileWithHalo> read = ReadTile(store_, tile_, halo_factor_);
    if (!read.ok()) return read.status();
    const TileCloud& cloud = read->cloud;
    result_.halo_points = cloud.points.size() - cloud.queries.size();
    ids_.reserve(cloud.queries.size());
    Box box;
    for (const TilePoint& point : cloud.points) box.Add(point.position);
    if (!FitsFloats(plan_, box)) {
      // Some point is far from all others. They are not to lose digits for it: parts are estimated instead.
      for (const uint32_t query : cloud.queries) {
        const TilePoint& point = cloud.points[query];
        ids_.push_back(point.id);
        uncertain.push_back({point, DistanceOf(point, kUnknown)});
      }
      return absl::OkStatus();
    }
    const FloatArrays arrays = ToFloats(plan_, cloud);
    absl::StatusOr<TileAnswer> answer = Ask(arrays, cloud.queries);
    if (!answer.ok()) return answer.status();
    for (size_t row = 0; row < cloud.queries.size(); ++row) {
      const TilePoint& point = cloud.points[cloud.queries[row]];
      ids_.push_back(point.id);
      if (answer->is_unusable[row]) continue;
      const double distance = DistanceOf(point, answer->radii[row]);
      if (HasAllWithin(plan_, *read, row, distance)) continue;
      // What was found may lie far beyond what was left out.
      uncertain.push_back({point, std::min(distance, DistanceOf(point, kUnknown))});
    }
    columns_ = std::move(answer->columns);
    return absl::OkStatus();
  }

  // Estimates points again, a group of near ones at a time; tells which have to be once more.
  absl::Status Repair(std::span<const Ball> balls, std::vector<Ball>& uncertain) {
    const uint64_t most_points = 2 * plan_.tile_points;
    const bool is_small = FitsFloats(plan_, BoxAround(balls)) && CountBalls(plan_, balls) <= most_points;
    if (balls.size() > 1 && !is_small) {
      std::vector<Ball> sorted(balls.begin(), balls.end());
      Box box;
      for (const Ball& ball : sorted) box.Add(ball.point.position);
      const size_t axis = box.LongestAxis();
      const auto middle = sorted.begin() + static_cast<ptrdiff_t>(sorted.size() / 2);
      std::nth_element(sorted.begin(), middle, sorted.end(), [axis](const Ball& a, const Ball& b) {
        return std::pair(a.point.position[axis], a.point.id) < std::pair(b.point.position[axis], b.point.id);
      });
      const std::span<const Ball> halves = sorted;
      absl::Status status = Repair(halves.first(sorted.size() / 2), uncertain);
      return status.ok() ? Repair(halves.subspan(sorted.size() / 2), uncertain) : status;
    }
    return RepairGroup({balls.begin(), balls.end()}, uncertain);
  }

  absl::Status RepairGroup(std::vector<Ball> balls, std::vector<Ball>& uncertain) {
    std::sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.point.id < b.point.id; });
    const absl::StatusOr<TileCloud> cloud = ReadBalls(store_, balls);
    if (!cloud.ok()) return cloud.status();
    const FloatArrays arrays = ToFloats(plan_, *cloud);
    const absl::StatusOr<TileAnswer> answer = Ask(arrays, cloud->queries);
    if (!answer.ok()) return answer.status();
    result_.repair_points += cloud->points.size();
    if (arrays.coarse_spacing > 0.0) result_.coarse_points += balls.size();
    for (size_t i = 0; i < balls.size(); ++i) {
      const auto row =
          static_cast<size_t>(std::lower_bound(ids_.begin(), ids_.end(), balls[i].point.id) - ids_.begin());
      Replace(answer->columns, i, row);
      const double distance = DistanceOf(balls[i].point, answer->radii[i]);
      if (!answer->is_unusable[i] && distance > balls[i].distance + kStepsOff * arrays.coarse_spacing) {
        uncertain.push_back({balls[i].point, distance});
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<TileAnswer> Ask(const FloatArrays& arrays, const std::vector<uint32_t>& queries) {
    absl::StatusOr<TileAnswer> answer = estimator_(arrays, queries);
    if (!answer.ok()) return answer;
    result_.has_opposed_normals = result_.has_opposed_normals || answer->has_opposed_normals;
    result_.has_normals_off_surface = result_.has_normals_off_surface || answer->has_normals_off_surface;
    return answer;
  }

  // How far a point's estimate looked.
  double DistanceOf(const TilePoint& point, float radius) const {
    const TileReach& reach = plan_.reach;
    if (reach.neighbor_count == 0) return reach.Around(reach.radius);
    if (!std::isnan(radius)) return reach.Around(double{radius});
    return reach.Around(plan_.tree.RadiusOf(point.position, reach.neighbor_count));
  }

  // Puts row `from` of other columns in the place of row `to`.
  void Replace(const std::vector<Column>& columns, size_t from, size_t to) {
    if (columns_.empty()) {
      for (const Column& column : columns) {
        columns_.push_back({column.name, MakeValues(column.kind())});
        std::visit([this](auto& values) { values.resize(ids_.size()); }, columns_.back().values);
      }
    }
    for (size_t c = 0; c < columns_.size(); ++c) {
      std::visit(
          [&](auto& values) {
            using Values = std::decay_t<decltype(values)>;
            values[to] = std::get<Values>(columns[c].values)[from];
          },
          columns_[c].values);
    }
  }

  const PointStore& store_;
  const TilePlan& plan_;
  const size_t tile_;
  const double halo_factor_;
  const TileEstimator& estimator_;
  TileResult result_;
  std::vector<uint64_t> ids_;    // of the tile's points
  std::vector<Column> columns_;  // their results
};

}  // namespace

absl::StatusOr<TileResult> EstimateTile(const PointStore& store, size_t tile, double halo_factor,
                                        const TileEstimator& estimator) {
  return TileWork(store, tile, halo_factor, estimator).Run();
}

}  // namespace curv
