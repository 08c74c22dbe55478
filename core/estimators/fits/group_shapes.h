// Shape operators of the surfaces that were fitted to the points of a group, in doubles.
#pragma once

#include <cstddef>

#include "core/index/spatial_index.h"

namespace curvd {

// A quantity of each point of a group.
using GroupDoubles = double[SpatialIndex::kGroupPoints];

struct alignas(64) GroupDoubleVectors {
  GroupDoubles x, y, z;

  void Set(size_t i, const double* v) {
    x[i] = v[0];
    y[i] = v[1];
    z[i] = v[2];
  }
};

// Shape operator of each point's surface: curvature in units of 1 / rho.
struct alignas(64) GroupShapes {
  GroupDoubles mean, gaussian, half_difference;
  GroupDoubleVectors d1, d2;
};

}  // namespace curvd
