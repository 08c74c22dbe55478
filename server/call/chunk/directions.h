// In which direction the normal curvature of each point is wanted.
#pragma once

#include "absl/status/status.h"
#include "core/estimators/normal_curvature.h"
#include "server/call/chunk/point_vectors.h"

namespace curvd {

// As unit vectors, in floats; (0, 0, 0) for those that are 0 or not finite.
class Directions : public PointVectors<float> {
 public:
  // Appends directions of `type`, any values. Errors: ErrorKind::kOutOfMemory. REQUIRES: `pieces` hold whole points.
  absl::Status Append(const curvature::wire::Pieces& pieces, ScalarType type) {
    return AppendKept(pieces, type, &DirectionOf);
  }
};

}  // namespace curvd
