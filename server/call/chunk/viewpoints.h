// Where each point of a cloud was seen from.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "server/call/chunk/point_vectors.h"

namespace curvd {

// As doubles.
class Viewpoints : public PointVectors<double> {
 public:
  // Appends viewpoints of `type`, any values. Errors: ErrorKind::kOutOfMemory. REQUIRES: `pieces` hold whole points.
  absl::Status Append(const curvature::wire::Pieces& pieces, ScalarType type);

  // How many viewpoints in a row, from `first` on, are finite: `most` at most. REQUIRES: first + most <= size().
  size_t FiniteRun(size_t first, size_t most) const;
};

}  // namespace curvd
