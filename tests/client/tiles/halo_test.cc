// What goes along with a tile, and whether that is certain to be enough, against all points of the cloud.
#include "client/tiles/points/halo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <vector>

#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

using testing::PlanHills;
using testing::ScratchDirectory;

constexpr size_t kPoints = 6000;
constexpr uint64_t kTilePoints = 1500;
constexpr uint32_t kNeighbors = 20;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool HasLowerId(const TilePoint& a, const TilePoint& b) { return a.id < b.id; }

double DistanceBetween(const Position& a, const Position& b) { return Box{a, a}.DistanceTo(b); }

// A plan, and all its points by id.
class HaloTest : public ::testing::Test {
 protected:
  void Plan(const TileReach& reach) {
    plan_ = PlanHills(scratch_, kPoints, kTilePoints, reach);
    absl::StatusOr<PointStore> store = PointStore::Open(plan_);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = std::make_unique<PointStore>(*std::move(store));
    ASSERT_TRUE(store_->Append(0, kPoints, all_).ok());
    std::sort(all_.begin(), all_.end(), HasLowerId);
    ASSERT_GE(plan_.tiles.size(), 4u);
  }

  TileWithHalo Read(size_t tile, double factor) const {
    absl::StatusOr<TileWithHalo> read = ReadTile(*store_, tile, factor);
    EXPECT_TRUE(read.ok()) << read.status();
    return read.ok() ? *std::move(read) : TileWithHalo();
  }

  std::vector<TilePoint> LeftOut(const TileCloud& cloud) const {
    std::vector<TilePoint> left_out;
    std::set_difference(all_.begin(), all_.end(), cloud.points.begin(), cloud.points.end(),
                        std::back_inserter(left_out), HasLowerId);
    return left_out;
  }

  // The radius of a point's neighborhood in the whole cloud.
  double RadiusOf(const Position& p) const {
    std::vector<double> distances;
    distances.reserve(all_.size());
    for (const TilePoint& other : all_) distances.push_back(DistanceBetween(p, other.position));
    std::nth_element(distances.begin(), distances.begin() + kNeighbors - 1, distances.end());
    return distances[kNeighbors - 1];
  }

  const CellNode& NodeAt(int32_t node) const { return plan_.tree.nodes()[static_cast<size_t>(node)]; }

  // Whether a cell of which nothing was read is within a distance.
  bool IsNearUnread(const Position& p, size_t tile, const TileWithHalo& read, double distance) const {
    const CellNode& own = plan_.tile(tile);
    bool is_near = false;
    plan_.tree.ForEachNear(p, distance, [&](int32_t cell) {
      const bool is_own = NodeAt(cell).first >= own.first && NodeAt(cell).first < own.first + own.count;
      is_near = is_near || !(is_own || std::any_of(read.read.begin(), read.read.end(),
                                                   [&](const ReadCell& one) { return one.cell == cell; }));
    });
    return is_near;
  }

  const ScratchDirectory scratch_;
  TilePlan plan_;
  std::unique_ptr<PointStore> store_;
  std::vector<TilePoint> all_;
};

TEST_F(HaloTest, IsCertainWhereNoPointThatWasLeftOutIsNearAndNowhereElse) {
  Plan({.neighbor_count = kNeighbors, .radius = 0.0, .factor = 1.5});
  for (const double factor : {0.0, 0.5, 1.25}) {
    size_t certain = 0, uncertain = 0;
    for (size_t tile = 0; tile < plan_.tiles.size(); ++tile) {
      const TileWithHalo read = Read(tile, factor);
      const std::vector<TilePoint> left_out = LeftOut(read.cloud);
      ASSERT_EQ(read.cells.size(), read.cloud.queries.size());
      for (size_t query = 0; query < read.cells.size(); query += 3) {
        const Position& p = read.cloud.points[read.cloud.queries[query]].position;
        double nearest = kInfinity;
        for (const TilePoint& other : left_out) nearest = std::min(nearest, DistanceBetween(p, other.position));
        const double reach = plan_.reach.Around(RadiusOf(p));
        for (const double distance :
             {0.0, 0.5 * reach, reach, 2.0 * reach, nearest * (1.0 - 1e-12), nearest * (1.0 + 1e-12), kInfinity}) {
          const bool has_all = HasAllWithin(plan_, read, query, distance);
          ++(has_all ? certain : uncertain);
          if (has_all) {
            EXPECT_GT(nearest, distance) << "tile " << tile << ", query " << query << ", factor " << factor;
          } else {
            EXPECT_TRUE(nearest <= distance || IsNearUnread(p, tile, read, distance))
                << "tile " << tile << ", query " << query << ", factor " << factor << ", distance " << distance;
          }
        }
      }
    }
    EXPECT_GT(certain, kPoints / 3);
    EXPECT_GT(uncertain, kPoints / 3);
  }
}

TEST_F(HaloTest, HoldsThePointsThatAreNearerToPointsOfACellThanItIsWideThere) {
  Plan({.neighbor_count = kNeighbors, .radius = 0.0, .factor = 1.5});
  for (const double factor : {0.0, 0.5, 1.25}) {
    for (size_t tile = 0; tile < plan_.tiles.size(); ++tile) {
      const TileWithHalo read = Read(tile, factor);
      ASSERT_EQ(read.cloud.queries.size(), plan_.tile(tile).count);
      ASSERT_TRUE(std::is_sorted(read.cloud.points.begin(), read.cloud.points.end(), HasLowerId));
      const auto is_near_cell = [&](const TilePoint& point) {
        return std::any_of(read.own.begin(), read.own.end(), [&](const OwnCell& own) {
          return NodeAt(own.cell).box.DistanceTo(point.position) < own.width;
        });
      };
      const auto is_near_point = [&](const TilePoint& point) {
        for (size_t query = 0; query < read.cells.size(); ++query) {
          const Position& p = read.cloud.points[read.cloud.queries[query]].position;
          if (DistanceBetween(p, point.position) < read.own[read.cells[query]].width) return true;
        }
        return false;
      };
      std::set<uint32_t> queries;
      for (size_t query = 0; query < read.cells.size(); ++query) {
        const uint32_t place = read.cloud.queries[query];
        queries.insert(place);
        EXPECT_EQ(plan_.tree.CellOf(read.cloud.points[place].position), read.own[read.cells[query]].cell);
      }
      for (uint32_t i = 0; i < read.cloud.points.size(); ++i) {
        EXPECT_TRUE(queries.contains(i) || is_near_cell(read.cloud.points[i])) << "tile " << tile;
      }
      for (const TilePoint& point : LeftOut(read.cloud)) EXPECT_FALSE(is_near_point(point)) << "tile " << tile;
      EXPECT_EQ(read.cloud.points.size() > queries.size(), factor > 0.0);
    }
  }
}

TEST_F(HaloTest, IsHardlyLargerThanWhatEstimatesLookAt) {
  Plan({.neighbor_count = kNeighbors, .radius = 0.0, .factor = 1.0});
  size_t needed = 0, halo = 0, near_box = 0, uncertain = 0;
  for (size_t tile = 0; tile < plan_.tiles.size(); ++tile) {
    const TileWithHalo read = Read(tile, 1.25);
    const std::vector<TilePoint> others = LeftOut(Read(tile, 0.0).cloud);
    std::vector<bool> is_needed(kPoints);
    double widest = 0.0;
    for (size_t query = 0; query < read.cells.size(); ++query) {
      const Position& p = read.cloud.points[read.cloud.queries[query]].position;
      const double reach = plan_.reach.Around(RadiusOf(p));
      widest = std::max(widest, reach);
      uncertain += HasAllWithin(plan_, read, query, reach) ? 0 : 1;
      for (const TilePoint& other : others) {
        if (DistanceBetween(p, other.position) <= reach) is_needed[other.id] = true;
      }
    }
    needed += static_cast<size_t>(std::count(is_needed.begin(), is_needed.end(), true));
    halo += read.cloud.points.size() - read.cloud.queries.size();
    for (const TilePoint& other : others) {
      near_box += plan_.tile(tile).box.DistanceTo(other.position) < widest ? 1 : 0;
    }
  }
  EXPECT_LT(halo, 2 * needed);
  EXPECT_LT(halo, near_box / 3);  // of the points that the box of a tile would make go along
  EXPECT_LT(uncertain, kPoints / 100);
}

TEST_F(HaloTest, IsAsWideAsAGivenRadiusReachesAndNoWider) {
  Plan({.neighbor_count = 0, .radius = 0.4, .factor = 1.5});
  for (size_t tile = 0; tile < plan_.tiles.size(); ++tile) {
    const TileWithHalo read = Read(tile, 1.25);
    for (size_t query = 0; query < read.cells.size(); ++query) {
      EXPECT_TRUE(HasAllWithin(plan_, read, query, plan_.reach.Around(0.4)));
    }
    EXPECT_EQ(read.cloud.points.size(), Read(tile, 1.0).cloud.points.size());
    EXPECT_GT(read.cloud.points.size(), Read(tile, 0.5).cloud.points.size());
    for (const TilePoint& point : read.cloud.points) {
      double nearest = kInfinity;
      for (const OwnCell& own : read.own) nearest = std::min(nearest, NodeAt(own.cell).box.DistanceTo(point.position));
      EXPECT_LE(nearest, plan_.reach.Around(0.4) * (1.0 + 1e-6));
    }
  }
}

}  // namespace
}  // namespace curv
