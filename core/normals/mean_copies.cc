#include "core/normals/mean_copies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/copies.h"
#include "core/base/median.h"

namespace curvd {

double MeanCopies(const SpatialIndex& index, size_t group) {
  using Position = std::array<float, 3>;
  std::array<Position, SpatialIndex::kGroupPoints> positions;
  size_t count = 0;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) positions[count++] = {points.x[i], points.y[i], points.z[i]};
  }
  constexpr size_t kTellDistance = 16;
  if (count <= kTellDistance) return 1.0;
  const auto squared = [&](size_t i, size_t j) {
    const float x = positions[i][0] - positions[j][0], y = positions[i][1] - positions[j][1],
                z = positions[i][2] - positions[j][2];
    return x * x + y * y + z * z;
  };
  // Of neighborhoods of so many points, itself included.
  std::vector<double> radii;
  std::array<float, SpatialIndex::kGroupPoints> distances;
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) distances[j] = squared(i, j);
    std::nth_element(distances.begin(), distances.begin() + (kTellDistance - 1), distances.begin() + count);
    radii.push_back(std::sqrt(distances[kTellDistance - 1]));
  }
  NearCopies copies(static_cast<float>(Median(radii)), kTellDistance);
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < i; ++j) copies.AddPair(squared(i, j));
  }
  const float most = copies.Exist() ? copies.distance() * copies.distance() : 0.0f;
  size_t pairs = 0;  // each point's with itself included
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) pairs += squared(i, j) <= most ? 1 : 0;
  }
  return static_cast<double>(pairs) / static_cast<double>(count);
}

}  // namespace curvd
