#include "client/tiles/cells/neighbor_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "client/tiles/cell_tree.h"

namespace curv {
namespace {

// A strip of three lengths by one. Beyond a third of its length it is 16 times denser.
std::vector<Position> Strip() {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Position> points;
  for (int i = 0; i < 33'000; ++i) {
    const double x = i < 1000 ? unit(random) : 1.0 + 2.0 * unit(random);
    points.push_back({x, unit(random), 0.0});
  }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

size_t CountCut(const std::vector<NeighborEdge>& edges, size_t axis, double cut) {
  return static_cast<size_t>(
      std::count_if(edges.begin(), edges.end(), [&](const NeighborEdge& edge) { return edge.IsCut(axis, cut); }));
}

TEST(NeighborEdges, CutsPartAsManyAsTheLengthInNeighborhoodsIs) {
  const std::vector<NeighborEdge> edges = EdgesOfNeighbors(Strip());
  const auto sparse = static_cast<double>(CountCut(edges, 0, 0.5)),
             dense = static_cast<double>(CountCut(edges, 0, 2.0)), along = static_cast<double>(CountCut(edges, 1, 0.5));
  EXPECT_GT(sparse, 50.0);
  EXPECT_NEAR(dense / sparse, 4.0, 1.0);  // neighborhoods are four times smaller
  EXPECT_NEAR(along / sparse, 1.0 + 2.0 * 4.0, 2.0);
}

TEST(NeighborEdges, AreFewWhereThereAreFewPoints) {
  EXPECT_TRUE(EdgesOfNeighbors({}).empty());
  const std::vector<Position> pair = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(EdgesOfNeighbors(std::span(pair).first(1)).empty());
  EXPECT_EQ(EdgesOfNeighbors(pair).size(), 2u);
}

// Two sheets, one above the other: a cut across the longest extent would part both.
TEST(NeighborEdges, LetTilesBeCutBetweenSheets) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Position> points;
  for (int i = 0; i < 4000; ++i) points.push_back({1.2 * unit(random), unit(random), i % 2 == 0 ? 0.0 : 0.5});
  const CellTree tree = CellTree::Divide(points, {.tiles = 2, .cells_per_tile = 4});
  EXPECT_EQ(tree.root().axis, 2);
}

TEST(NeighborEdges, LetWhatIsTooLongBeCutInTheMiddle) {
  std::vector<Position> points = Strip();
  CellTree tree = CellTree::Divide(points, {.tiles = 1, .cells_per_tile = 64, .most_extent = 1.7});
  EXPECT_EQ(tree.root().axis, 0);
  EXPECT_NEAR(tree.root().cut, 1.5, 1e-3);
  for (const Position& p : points) tree.Count(tree.CellOf(p), p);
  EXPECT_EQ(tree.MakeTiles(100'000, 1.7), 2);
}

}  // namespace
}  // namespace curv
