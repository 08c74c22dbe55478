// How much memory a job needs: what admission should reserve.
#pragma once

#include <cstddef>

#include "core/estimators/options.h"
#include "core/normals/normal_options.h"

namespace curvd {

// Bytes that estimating one point needs at the peak, cloud and field included.
size_t EstimationBytesPerPoint(const EstimatorOptions& options, const NormalOptions& normals = {});

// The most bytes of scratch that the threads of a pool hold while they estimate a cloud of `point_count` points, each
// for itself and all together: threads that get no block of a small cloud need none.
size_t EstimationScratchBytes(const EstimatorOptions& options, size_t point_count, int thread_count,
                              const NormalOptions& normals = {});

// The same for a job that makes normals alone.
size_t NormalsJobBytesPerPoint(const NormalOptions& normals);
size_t NormalsJobScratchBytes(const NormalOptions& normals, size_t point_count, int thread_count);

}  // namespace curvd
