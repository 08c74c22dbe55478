// Curvature of a point beside a sharp edge, from the positions of the neighbors on its own side.
#pragma once

#include <optional>
#include <span>

#include "core/scale/edges/side_estimate.h"
#include "core/scale/normal_fits/neighbor_normal.h"
#include "core/scale/normal_fits/normal_polynomials.h"

namespace curvd {

// Fits polynomials of degree 2 and 4 to the heights over the frame's plane, of as many neighbors as leave the least
// error: by what the fit leaves, all of which may be of one sign. So where positions have noise, the error is larger
// than chance makes it. Nothing where neighbors are too few. REQUIRES: `side` is sorted by distance; `radius`, the
// largest of these, is above 0.
std::optional<SideEstimate> EstimateByHeights(const NormalFrame& frame, std::span<const NeighborNormal* const> side,
                                              double radius);

}  // namespace curvd
