#include "client/tiles/cell_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace curv {
namespace {

// Many points in a square, as many in a corner of it that is a thousand times smaller, some at one place, one far away.
std::vector<Position> HardCloud() {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Position> points;
  for (int i = 0; i < 4000; ++i) points.push_back({unit(random), unit(random), 0.0});
  for (int i = 0; i < 4000; ++i) points.push_back({unit(random) / 1000, unit(random) / 1000, 0.0});
  for (int i = 0; i < 1000; ++i) points.push_back({0.5, 0.5, 0.0});
  points.push_back({1e9, 1e9, 1e9});
  return points;
}

CellTree TreeOf(const std::vector<Position>& points, uint64_t tiles, uint64_t most_points) {
  CellTree tree = CellTree::Divide(points, {.tiles = tiles, .cells_per_tile = 16});
  for (const Position& p : points) tree.Count(tree.CellOf(p), p);
  tree.MakeTiles(most_points, 1e300);
  return tree;
}

double DistanceBetween(const Position& a, const Position& b) { return Box{a, a}.DistanceTo(b); }

TEST(CellTree, TilesHoldAllPointsAndFewEach) {
  const std::vector<Position> points = HardCloud();
  const CellTree tree = TreeOf(points, 9, 1100);
  uint64_t next = 0;
  for (const int32_t node : tree.TileNodes()) {
    const CellNode& tile = tree.nodes()[static_cast<size_t>(node)];
    EXPECT_EQ(tile.first, next);
    EXPECT_GT(tile.count, 0u);
    EXPECT_TRUE(tile.count <= 1100 || tile.is_cell()) << tile.count;
    next += tile.count;
  }
  EXPECT_EQ(next, points.size());
  EXPECT_GE(tree.TileNodes().size(), 8u);
}

TEST(CellTree, KeepsPointsAtOnePlaceTogether) {
  const std::vector<Position> points(500, Position{1.0, 2.0, 3.0});
  const CellTree tree = TreeOf(points, 5, 100);
  ASSERT_EQ(tree.TileNodes().size(), 1u);
  EXPECT_EQ(tree.root().count, 500u);
}

TEST(CellTree, FindsEveryCellThatIsNear) {
  const std::vector<Position> points = HardCloud();
  const CellTree tree = TreeOf(points, 9, 1100);
  for (size_t i = 0; i < points.size(); i += 501) {
    for (const double distance : {0.0, 1e-4, 0.03, 2e9}) {
      std::vector<int32_t> near;
      tree.ForEachNear(points[i], distance, [&](int32_t cell) { near.push_back(cell); });
      for (const Position& other : points) {
        if (DistanceBetween(points[i], other) > distance) continue;
        EXPECT_TRUE(std::binary_search(near.begin(), near.end(), tree.CellOf(other)));
      }
    }
  }
}

TEST(CellTree, BoundsTheDistanceOfTheKthPoint) {
  const std::vector<Position> points = HardCloud();
  const CellTree tree = TreeOf(points, 9, 1100);
  for (size_t i = 0; i < points.size(); i += 500) {
    for (const uint64_t count : {uint64_t{1}, uint64_t{50}, uint64_t{5000}, uint64_t{points.size()}}) {
      const double radius = tree.RadiusOf(points[i], count);
      const auto within = std::count_if(points.begin(), points.end(), [&](const Position& other) {
        return DistanceBetween(points[i], other) <= radius * (1 + 1e-12);  // the root of a sum of squares rounds
      });
      EXPECT_GE(static_cast<uint64_t>(within), count);
    }
    EXPECT_TRUE(std::isinf(tree.RadiusOf(points[i], points.size() + 1)));
  }
}

TEST(CellTree, IsWhatItsBytesSay) {
  const CellTree tree = TreeOf(HardCloud(), 9, 1100);
  const absl::StatusOr<CellTree> read = CellTree::Parse(tree.Bytes());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->Bytes(), tree.Bytes());
  EXPECT_EQ(read->TileNodes(), tree.TileNodes());
}

TEST(CellTree, RefusesBytesThatNoTreeHas) {
  std::string bytes = TreeOf(HardCloud(), 9, 1100).Bytes();
  EXPECT_FALSE(CellTree::Parse("").ok());
  EXPECT_FALSE(CellTree::Parse(bytes.substr(1)).ok());
  for (const int32_t child : {-7, 0, 1 << 30}) {
    std::string changed = bytes;
    std::memcpy(changed.data() + sizeof(int32_t), &child, sizeof(child));  // the root's second child
    EXPECT_FALSE(CellTree::Parse(changed).ok()) << child;
  }
}

}  // namespace
}  // namespace curv
