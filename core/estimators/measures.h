// Corrected curvature measures of the points of a group.
#pragma once

#include "core/estimators/group_points.h"

namespace curvd {

// Measures of each point's neighborhood, of lengths in units of rho; the tensor in the tangent frame, its symmetric
// part. Kernels set them for the points that are estimated; Fill for the rest.
struct alignas(64) GroupMeasures {
  GroupScalars area;
  GroupScalars mean;
  GroupScalars gaussian;
  GroupScalars tensor_uu;
  GroupScalars tensor_uv;
  GroupScalars tensor_vv;

  void Fill(size_t i) { area[i] = mean[i] = gaussian[i] = tensor_uu[i] = tensor_uv[i] = tensor_vv[i] = 0.0f; }
};

}  // namespace curvd
