// What the neighbors on one side of a sharp edge say.
#pragma once

#include <cstddef>

#include "core/estimators/curvature_field.h"

namespace curvd {

// Lengths are in one unit.
struct SideEstimate {
  PointCurvature point;
  size_t neighbor_count;
  double mean_error, principal_error;  // standard errors of H, and of k1 and k2 each
  bool is_by_heights;                  // by the positions of the neighbors, otherwise by their normals
};

}  // namespace curvd
