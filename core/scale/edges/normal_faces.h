// Tells normals of faces that meet at an edge from those of a bend.
#pragma once

#include <span>

#include "core/scale/point_fits/neighbor_normal.h"

namespace curvd {

// The mean squared distance of normals from their mean, and from the nearest of the means of two and of three clusters.
// Between faces that meet at an edge nothing is left but noise, where a bend leaves a quarter and a ninth; three faces
// meet at a corner. As large as that from one mean where a cluster would be of fewer than 3.
struct NormalSpread {
  double all, in_two, in_three;
};

// In doubles. REQUIRES: there are neighbors.
NormalSpread SpreadOf(std::span<const NeighborNormal> neighbors);

// Whether the normals are of two or three faces, where noise of this standard deviation along each tangent is in them.
bool AreOfFaces(const NormalSpread& spread, double noise);

}  // namespace curvd
