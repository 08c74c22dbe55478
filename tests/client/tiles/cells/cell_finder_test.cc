#include "client/tiles/cells/cell_finder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace curv {
namespace {

std::vector<TilePoint> PointsOf(const std::vector<Position>& positions) {
  std::vector<TilePoint> points;
  for (const Position& p : positions) points.push_back({.position = p});
  return points;
}

// Denser by far in a corner, so that some cells are much deeper in the tree than others.
std::vector<Position> UnevenCloud(size_t count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Position> positions;
  for (size_t i = 0; i < count; ++i) {
    positions.push_back({std::pow(unit(random), 9.0), std::pow(unit(random), 3.0), unit(random)});
  }
  return positions;
}

TEST(CellFinder, FindsTheCellsOfTheTreeForAnyNumberOfPoints) {
  const std::vector<Position> positions = UnevenCloud(1003);
  const CellTree tree = CellTree::Divide(positions, {.tiles = 7, .cells_per_tile = 11});
  const CellFinder finder(tree);
  const std::vector<TilePoint> points = PointsOf(positions);
  for (const size_t count : {size_t{0}, size_t{1}, size_t{7}, size_t{8}, size_t{9}, points.size()}) {
    std::vector<int32_t> cells(count, -1);
    finder.Find(std::span(points).first(count), cells);
    for (size_t i = 0; i < count; ++i) EXPECT_EQ(cells[i], tree.CellOf(positions[i])) << i << " of " << count;
  }
}

TEST(CellFinder, PutsPointsOnCutsAndOutsideWhereTheTreeDoes) {
  const CellTree tree = CellTree::Divide(UnevenCloud(500), {.tiles = 5, .cells_per_tile = 5});
  std::vector<Position> positions = {{-1e300, -1e300, -1e300}, {1e300, 1e300, 1e300}};
  for (const CellNode& node : tree.nodes()) {
    if (node.is_cell()) continue;
    Position on_cut = {0.1, 0.1, 0.1};
    on_cut[static_cast<size_t>(node.axis)] = node.cut;
    positions.push_back(on_cut);
  }
  ASSERT_GT(positions.size(), 10u);
  std::vector<int32_t> cells(positions.size(), -1);
  CellFinder(tree).Find(PointsOf(positions), cells);
  for (size_t i = 0; i < positions.size(); ++i) EXPECT_EQ(cells[i], tree.CellOf(positions[i])) << i;
}

TEST(CellFinder, GivesAllPointsTheOneCellOfATreeWithoutCuts) {
  const std::vector<Position> positions = UnevenCloud(20);
  const CellTree tree = CellTree::Divide(positions, {});
  std::vector<int32_t> cells(positions.size(), -1);
  CellFinder(tree).Find(PointsOf(positions), cells);
  EXPECT_EQ(cells, std::vector<int32_t>(positions.size(), 0));
}

}  // namespace
}  // namespace curv
