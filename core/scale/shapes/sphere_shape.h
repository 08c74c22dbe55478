// The algebraic shape operator at a sampled point, projected on the surface.
#pragma once

#include <optional>
#include <span>

#include "core/scale/pilot/pilot_batch.h"
#include "core/scale/shapes/sphere_moments.h"
#include "core/scale/shapes/tangent_shape.h"

namespace curvd {

// What aso with `project` estimates (core/estimators/fits/algebraic_sphere-inl.h) of the neighbors within `radius`,
// `rim` being those of them at that distance, with the frame's z for the point's own normal. Nothing where the
// neighbors fix no sphere. `distinct` of them have positions of their own. Lengths are in the unit of the neighbors.
// REQUIRES: radius > 0.
std::optional<TangentShape> SphereShapeOf(const SphereMoments& moments, std::span<const PilotNeighbor> rim,
                                          double distinct, double radius);

}  // namespace curvd
