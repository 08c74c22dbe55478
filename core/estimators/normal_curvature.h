// The curvature of a surface in a direction.
#pragma once

#include <array>
#include <span>

#include "core/estimators/curvature_field.h"

namespace curvd {

// A direction of unit length, or (0, 0, 0) for none.
using Direction = std::array<float, 3>;

// The direction of a vector of any length; none if it is 0 or not finite.
Direction DirectionOf(const std::array<double, 3>& vector);

// The normal curvature in the direction, projected on the tangent plane: by Euler's theorem k1 cos^2 + k2 sin^2 of the
// angle from d1 to it (M. do Carmo, Differential Geometry of Curves and Surfaces, 1976, section 3-2). In 1 / the
// caller's length unit, with the sign of k1 and k2. NaN where the point has no curvature, or the direction none in the
// tangent plane: it is along the normal to 1e-6 of its length, the rounding of d1 and d2 with room.
float NormalCurvature(const PointCurvature& point, const Direction& direction);

// Writes it for each point to `out`, one float32 behind the other, aligned or not. `directions` has one for each point,
// or one for all.
void WriteNormalCurvatures(std::span<const PointCurvature> points, std::span<const Direction> directions, char* out);

}  // namespace curvd
