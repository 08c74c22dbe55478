// What the neighborhoods of a group's points came to, and the frame of each point that follows from its neighborhood.
#pragma once

#include "core/estimators/group_points.h"

namespace curvd {

// Set for each point as its neighborhood is found.
struct alignas(64) GroupNeighborhoods {
  GroupScalars count;           // of neighbors that the search found
  GroupScalars squared_radius;  // distance of the farthest of them
  GroupVectors normal_sum;      // over them
  GroupScalars agreement;       // the least cosine between the normal of one of them and the point's own
};

// Set by PreparePoints (core/estimators/frames-inl.h) from the neighborhoods. Lengths are in the index's unit. Points
// that are not estimated, and the rest of the group, have values that no kernel trips over.
struct alignas(64) GroupFrames {
  GroupVectors u, v;             // the tangent plane: u, v and the blended normal are right-handed
  GroupScalars rho;              // radius of the figure, > 0
  GroupScalars squared_spacing;  // the squared radius that holds one point of an even surface

  void Fill(size_t i) {
    constexpr float kX[3] = {1.0f, 0.0f, 0.0f}, kY[3] = {0.0f, 1.0f, 0.0f};
    u.Set(i, kX);
    v.Set(i, kY);
    rho[i] = 1.0f;
    squared_spacing[i] = 0.0f;
  }
};

}  // namespace curvd
