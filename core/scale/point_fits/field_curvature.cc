#include "core/scale/point_fits/field_curvature.h"

#include <cmath>

#include "core/scale/principal_directions.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

bool IsFinite(const PointCurvature& point) {
  return std::isfinite(point.gaussian) && std::isfinite(point.k1) && std::isfinite(point.k2);
}

}  // namespace

std::optional<PointCurvature> CurvatureOfField(const NormalFrame& frame, const Eigen::Matrix3d& field, double unit,
                                               double radius) {
  const Vector3d value = field.row(0), along_u = field.row(1), along_v = field.row(2);
  const double length = value.norm();
  const Vector3d normal = value / length;
  if (!(frame.n.dot(normal) > 0.1)) return std::nullopt;
  const Vector3d s = normal.unitOrthogonal(), t = normal.cross(s);
  const auto change = [&](const Vector3d& tangent) -> Vector3d {
    return (tangent.dot(frame.u) * along_u + tangent.dot(frame.v) * along_v) / (length * unit);
  };
  const double ss = change(s).dot(s), tt = change(t).dot(t), st = 0.5 * (change(s).dot(t) + change(t).dot(s));
  const double mean = 0.5 * (ss + tt), half = 0.5 * (ss - tt), difference = std::hypot(half, st);
  const PrincipalDirections directions = DirectionsOf(half, st, s, t, normal);
  const PointCurvature point = {static_cast<float>(mean),
                                static_cast<float>((mean - difference) * (mean + difference)),
                                static_cast<float>(mean - difference),
                                static_cast<float>(mean + difference),
                                directions.d1,
                                directions.d2,
                                static_cast<float>(radius),
                                PointStatus::kOk};
  return IsFinite(point) ? std::optional(point) : std::nullopt;
}

std::optional<PointCurvature> Scaled(PointCurvature point, double factor) {
  for (float* const curvature : {&point.mean, &point.k1, &point.k2}) {
    *curvature = static_cast<float>(*curvature * factor);
  }
  point.gaussian = static_cast<float>(point.gaussian * factor * factor);
  point.radius = static_cast<float>(point.radius / factor);
  return IsFinite(point) ? std::optional(point) : std::nullopt;
}

std::optional<PointFit> Scaled(PointFit fit, double factor) {
  const auto point = Scaled(fit.point, factor);
  if (!point.has_value()) return std::nullopt;
  fit.point = *point;
  for (double* const error : {&fit.mean_error, &fit.k1_error, &fit.k2_error}) *error *= factor;
  return fit;
}

}  // namespace curvd
