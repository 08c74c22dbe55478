// The corners of one hexagram of each point of a group.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/estimators/group_points.h"

namespace curvd {

// Corners as sums over neighbors: their offsets from the point and their number, and their normals less the point's own
// and nothing. By corner, point, and component, for LoadInterleaved4.
struct Hexagram {
  alignas(64) float offset[6][SpatialIndex::kGroupPoints][4];
  alignas(64) float normal[6][SpatialIndex::kGroupPoints][4];

  // A hexagram without neighbors: all corners at the point.
  void Fill(size_t i) {
    for (int s = 0; s < 6; ++s) {
      std::fill_n(offset[s][i], 4, 0.0f);
      std::fill_n(normal[s][i], 4, 0.0f);
    }
  }
};

}  // namespace curvd
