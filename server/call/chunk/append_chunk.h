// Takes points into a cloud from where gRPC received them.
#pragma once

#include "absl/status/status.h"
#include "core/cloud/cloud.h"
#include "proto/bulk_message.h"
#include "server/call/chunk/viewpoints.h"

namespace curvd {

// Cloud::Append for arrays in pieces: the points that lie together in both arrays at once, those that the end of a
// piece cuts one by one. Errors as there. REQUIRES: both arrays hold as many whole points of `type`; `normals` none if
// the cloud takes none.
absl::Status AppendPieces(const curvature::wire::Pieces& positions, const curvature::wire::Pieces& normals,
                          ScalarType type, Cloud& cloud);

// The same for points whose viewpoints were appended to `viewpoints` before: a point without a finite one is invalid.
// REQUIRES: `viewpoints` holds one for each point of the cloud and of the arrays.
absl::Status AppendSeenPieces(const curvature::wire::Pieces& positions, const curvature::wire::Pieces& normals,
                              ScalarType type, const Viewpoints& viewpoints, Cloud& cloud);

// Cloud::Describe for the next `count` points, from arrays in pieces: little-endian uint64 ids, and roles of one byte, as in
// curvature.v1.PointRole. An array without bytes is left out. Errors as there; kInvalid also for a byte that is no role.
// REQUIRES: an array holds `count` entries, or none.
absl::Status DescribePieces(const curvature::wire::Pieces& ids, const curvature::wire::Pieces& roles, size_t count,
                            Cloud& cloud);

}  // namespace curvd
