// The linear regression of the normals over space at a sampled point.
#pragma once

#include <optional>

#include "core/scale/pilot/pilot_sums.h"

namespace curvd {

// What normal-regression of degree 1 estimates (core/estimators/fits/linear_regression-inl.h), with the frame's normal
// as the point's own; nothing where the neighbors fix no surface. `distinct` of them have positions of their own.
std::optional<TangentShape> LinearShapeOf(const PilotSums& sums, double distinct);

}  // namespace curvd
