#include "core/scale/shapes/tangent_shape.h"

namespace curvd {

TangentShape ShapeOf(double e, double f, double g, double xx, double xy, double yy) {
  const double determinant = e * g - f * f;
  return {0.5 * (g * xx - 2.0 * f * xy + e * yy) / determinant, 0.5 * (g * xx - e * yy) / determinant,
          0.5 * ((e + g) * xy - f * (xx + yy)) / determinant};
}

TangentShape ShapeOf(const Eigen::Vector3d& tangent_x, const Eigen::Vector3d& tangent_y,
                     const Eigen::Vector3d& normal_x, const Eigen::Vector3d& normal_y) {
  return ShapeOf(tangent_x.squaredNorm(), tangent_x.dot(tangent_y), tangent_y.squaredNorm(), tangent_x.dot(normal_x),
                 0.5 * (tangent_x.dot(normal_y) + tangent_y.dot(normal_x)), tangent_y.dot(normal_y));
}

}  // namespace curvd
