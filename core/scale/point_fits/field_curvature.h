// The curvature that a field of normals over a plane shows.
#pragma once

#include <optional>

#include "Eigen/Core"
#include "core/estimators/curvature_field.h"
#include "core/scale/point_fits/normal_polynomials.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// By the field's value and its derivatives along u and v of the frame at the origin, a row each, with u and v in
// multiples of `unit` (docs/numerics.md). The result has that radius, and no status but kOk. Nothing where the normals
// do not determine it.
std::optional<PointCurvature> CurvatureOfField(const NormalFrame& frame, const Eigen::Matrix3d& field, double unit,
                                               double radius);

// The same in another unit of length, of which the old one has 1 / `factor`. Nothing where a value is beyond floats.
std::optional<PointCurvature> Scaled(PointCurvature point, double factor);
std::optional<PointFit> Scaled(PointFit fit, double factor);

}  // namespace curvd
