#include "client/tiles/lattice.h"

#include <algorithm>
#include <vector>

#include "client/tiles/cell_tree.h"

namespace curv {
namespace {

constexpr int kStepsPerDistance = 12;    // 2^12
constexpr uint64_t kPointsInCell = 64;   // enough that a cell's box is as large as its piece of surface
constexpr double kDoubleSteps = 0x1p51;  // of the largest coordinate; a double holds two bits more

double PowerOfTwoBelow(double number) { return std::exp2(std::floor(std::log2(number))); }

// The area of a piece of surface that fills a box: that of its largest side.
double AreaOf(const Box& box) {
  std::array<double, 3> extents = {box.Extent(0), box.Extent(1), box.Extent(2)};
  std::sort(extents.begin(), extents.end());
  return extents[1] * extents[2];
}

}  // namespace

double LatticeSpacing(std::span<const Position> sample, uint64_t points) {
  double largest = 0.0;
  for (const Position& p : sample) {
    for (const double coordinate : p) largest = std::max(largest, std::abs(coordinate));
  }
  if (largest == 0.0) return 1.0;
  const double finest = PowerOfTwoBelow(largest) / kDoubleSteps;
  CellTree tree =
      CellTree::Divide({sample.begin(), sample.end()}, {.cells_per_tile = sample.size() / kPointsInCell + 1});
  for (const Position& p : sample) tree.Count(tree.CellOf(p), p);
  const double points_each = static_cast<double>(points) / static_cast<double>(sample.size());
  std::vector<double> distances;
  for (const CellNode& node : tree.nodes()) {
    if (!node.is_cell() || node.count < 2) continue;
    distances.push_back(std::sqrt(AreaOf(node.box) / (static_cast<double>(node.count) * points_each)));
  }
  if (distances.empty()) return finest;
  const auto middle = distances.begin() + static_cast<ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  if (!(*middle > 0.0)) return finest;
  return std::max(finest, PowerOfTwoBelow(std::ldexp(*middle, -kStepsPerDistance)));
}

double SpacingFor(double extent, double spacing) {
  // The origin lies on the lattice, up to half a step from the middle.
  while (extent / 2.0 > (kMostSteps - 1.0) * spacing) spacing *= 2.0;
  return spacing;
}

}  // namespace curv
