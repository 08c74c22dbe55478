// Neighborhoods that lie along one line of a scan, where nothing can be said of the curvature across it.
#pragma once

#include "core/search/neighbor_offsets.h"

namespace curvd {

// Neighbors of one point in their tangent plane, along the line in which they spread most, and across it.
struct LineSpread {
  double along;      // standard deviations, in units of the radius: along the line,
  double across;     // across it, and
  double thickness;  // along the normal, both about a parabola over the line

  // Whether the width across the line may be noise alone, or is next to nothing.
  bool IsLine() const;
};

// `normal` has unit length; `radius` > 0 is that of the neighborhood. With `fades`, a neighbor at distance d counts
// (1 - (d / radius)^2)^2. The result does not depend on the order of the neighbors.
LineSpread MeasureLine(const NeighborOffsets& neighbors, const float* normal, float radius, bool fades);

}  // namespace curvd
