#include "core/normals/sample_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace curvd {

std::vector<size_t> SampleGroups(const SpatialIndex& index, size_t most) {
  const size_t groups = std::min(index.group_count(), most);
  std::vector<size_t> sample;
  sample.reserve(groups);
  for (size_t i = 0; i < groups; ++i) sample.push_back((2 * i + 1) * index.group_count() / (2 * groups));
  return sample;
}

double LatticeStep(const SpatialIndex& index) {
  constexpr size_t kMostLeaves = 4096;
  // Of n values at random in an interval, the two that lie nearest to each other are a part of 1 / n^2 apart.
  constexpr double kMoreThanChance = 30.0;
  const size_t step = std::max<size_t>(index.leaf_count() / kMostLeaves, 1);
  double finest = std::numeric_limits<double>::infinity();
  for (const auto axis :
       {&SpatialIndex::LeafPositions::x, &SpatialIndex::LeafPositions::y, &SpatialIndex::LeafPositions::z}) {
    std::vector<float> values;
    for (size_t leaf = 0; leaf < index.leaf_count(); leaf += step) {
      values.push_back((index.positions(leaf).*axis)[0]);
    }
    std::sort(values.begin(), values.end());
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 1; i < values.size(); ++i) {
      const double gap = static_cast<double>(values[i]) - values[i - 1];
      if (gap > 0.0) least = std::min(least, gap);
    }
    const double extent = static_cast<double>(values.back()) - values.front();
    const double count = static_cast<double>(values.size());
    if (extent > 0.0) finest = std::min(finest, least * count * count > kMoreThanChance * extent ? least : 0.0);
  }
  return std::isfinite(finest) ? finest : 0.0;
}

}  // namespace curvd
