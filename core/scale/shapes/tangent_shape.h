// The shape operator at a sampled point.
#pragma once

#include "Eigen/Core"

namespace curvd {

// The shape operator over the frame's x and y, [[mean + difference, twist], [twist, mean - difference]].
struct TangentShape {
  double mean;
  double difference;
  double twist;
};

// That of a surface with the first fundamental form (e, f, g) and the second one (xx, xy, yy).
TangentShape ShapeOf(double e, double f, double g, double xx, double xy, double yy);
// The same of a surface with these tangents, whose x and y are (1, 0) and (0, 1), and derivatives of its unit normal
// along them.
TangentShape ShapeOf(const Eigen::Vector3d& tangent_x, const Eigen::Vector3d& tangent_y,
                     const Eigen::Vector3d& normal_x, const Eigen::Vector3d& normal_y);

}  // namespace curvd
