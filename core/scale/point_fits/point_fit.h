// What a fit to the neighbors of one point says.
#pragma once

#include <cstddef>

#include "core/estimators/curvature_field.h"

namespace curvd {

// Lengths are in one unit.
struct PointFit {
  PointCurvature point;
  size_t neighbor_count;
  double mean_error, k1_error, k2_error;  // standard errors of the curvatures
  bool is_by_heights;                     // by the positions of the neighbors, otherwise by their normals
};

}  // namespace curvd
