// A neighbor of a point with its normal, in doubles.
#pragma once

#include "Eigen/Core"

namespace curvd {

struct NeighborNormal {
  Eigen::Vector3d offset;  // from the point
  Eigen::Vector3d normal;  // of unit length
};

}  // namespace curvd
