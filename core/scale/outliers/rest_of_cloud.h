// A cloud without some of its points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Makes a cloud of the points of `index`, each at its rank, but for `left_out`, ranks in ascending order, and for those
// that the index does not hold: these are invalid points, nobody's neighbors. It has the normals of the index, if
// `takes_normals`, and lies relative to the same origin; its own is 0. Frees the index before the cloud is made.
// Errors: ErrorKind::kOutOfMemory. May throw std::bad_alloc. REQUIRES: all points are queries without ids
// (PointSet), of a cloud of `size` points.
absl::StatusOr<Cloud> RestOfCloud(SpatialIndex index, size_t size, std::span<const int32_t> left_out,
                                  bool takes_normals);

}  // namespace curvd
