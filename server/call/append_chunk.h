// Takes points into a cloud from where gRPC received them.
#pragma once

#include "absl/status/status.h"
#include "core/cloud/cloud.h"
#include "proto/bulk_message.h"

namespace curvd {

// Cloud::Append for arrays in pieces: the points that lie together in both arrays at once, those that the end of a
// piece cuts one by one. Errors as there. REQUIRES: both arrays hold as many whole points of `type`.
absl::Status AppendPieces(const curvature::wire::Pieces& positions, const curvature::wire::Pieces& normals,
                          ScalarType type, Cloud& cloud);

}  // namespace curvd
