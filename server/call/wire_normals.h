// Normals on the wire: what a header asks for, and what a summary tells of them.
#pragma once

#include "absl/status/status.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/request_limits.h"

namespace curvd {

// Sets `options` to what `proto` asks for; the viewpoints of points are still to come. Errors, each with its
// ErrorDetail:
// - INVALID_ARGUMENT: a field is out of its range, missing, or set where it would have no effect.
// - RESOURCE_EXHAUSTED: neighbor_count is over the limit of this server.
absl::Status ReadNormals(const curvature::v1::NormalOptions& proto, const CallLimits& limits, NormalOptions& options);

curvature::v1::NormalMethod WireNormalMethod(NormalMethod method);

// The answer to that, with every default but those that the points decide.
void WriteNormals(const NormalOptions& options, curvature::v1::NormalOptions& proto);

// What a summary tells of the normals.
void WriteReport(const NormalReport& report, curvature::v1::NormalsReport& proto);

}  // namespace curvd
