// Curvature of a point from the heights of its neighbors over a plane.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/scale/point_fits/neighbor_normal.h"
#include "core/scale/point_fits/normal_polynomials.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// Fits polynomials of degree 2 and 4 to the heights over the frame's plane, of as many neighbors as leave the least
// error, at least `least_count`: by what the fit leaves, all of which may be of one sign. So where positions have
// noise, the error is larger than chance makes it. It is not less than what `noise`, the standard deviation of
// positions, makes. Of those whose intervals, of nine in ten, have something in common with those of degree 4 with
// fewer neighbors: others have smoothed detail away (core/scale/detail/interval_climb.h). Nothing where neighbors are
// too few, or lie on so few lines that a polynomial goes through them whatever they have in common. REQUIRES:
// `neighbors` are sorted by distance; the last of them is not at the point.
std::optional<PointFit> EstimateByHeights(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors,
                                          uint32_t least_count, double noise);

}  // namespace curvd
