// Fits to the positions that given normals prove to be those of.
#pragma once

#include <cstdint>

#include "core/normals/normal_options.h"

namespace curvd {

struct FittedNormals {
  NormalMethod method;
  uint32_t neighbor_count;  // the point itself included; the median over a sample where all within a radius were taken
};

}  // namespace curvd
