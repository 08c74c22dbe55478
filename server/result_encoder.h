// Turns a part of a field into the packed arrays of a ResultChunk.
#pragma once

#include <cstddef>

#include "core/curvature_field.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call_options.h"

namespace curvd {

// Points of one ResultChunk: at most 45 bytes each, so that a message stays below 1 MiB, far from the 4 MiB that gRPC
// clients take by default.
inline constexpr size_t kResultChunkPoints = 16'384;
inline constexpr size_t kResultBytesPerPoint = 45;

// Fills `chunk` with the results of points [first, first + count), the arrays in `quantities` only. Takes about 4 ns a
// point; keeps the memory that `chunk` held. REQUIRES: first + count <= points.size().
void EncodeResults(const PageArray<PointCurvature>& points, size_t first, size_t count, const QuantitySet& quantities,
                   curvature::v1::ResultChunk* chunk);

}  // namespace curvd
