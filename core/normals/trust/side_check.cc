#include "core/normals/trust/side_check.h"

#include <algorithm>

namespace curvd {

SideCheck::SideCheck(const SpatialIndex& index) : index_(index) {
  kept_.resize(std::min(index.point_count(), kMostSamples));
  for (size_t i = 0; i < kept_.size(); ++i) kept_[i] = NormalAt(i);
}

std::array<float, 3> SideCheck::NormalAt(size_t sample) const {
  const size_t place = sample * index_.point_count() / kept_.size();
  const SpatialIndex::LeafNormals& n = index_.normals(place / SpatialIndex::kLeafSize);
  const size_t lane = place % SpatialIndex::kLeafSize;
  return {n.x[lane], n.y[lane], n.z[lane]};
}

double SideCheck::TurnedShare() const {
  size_t same = 0, other = 0;
  for (size_t i = 0; i < kept_.size(); ++i) {
    const std::array<float, 3> now = NormalAt(i), then = kept_[i];
    const float dot = now[0] * then[0] + now[1] * then[1] + now[2] * then[2];
    same += dot >= 0.0f ? 1 : 0;
    other += dot < 0.0f ? 1 : 0;  // neither if one is NaN
  }
  return same + other > 0 ? static_cast<double>(std::min(same, other)) / static_cast<double>(same + other) : 0.0;
}

}  // namespace curvd
