// Resolves what a CloudHeader asks for: checks it, and fills in every default.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/estimators/normal_curvature.h"
#include "core/estimators/options.h"
#include "core/job/worker_pool.h"
#include "core/normals/normal_options.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/chunk/wire_part.h"
#include "server/call/quantity_set.h"
#include "server/call/request_limits.h"

namespace curvd {

struct CallOptions {
  uint64_t point_count = 0;       // 0: unknown
  bool marks_last_chunk = false;  // a cloud without a marked chunk is incomplete
  ScalarType scalar_type = ScalarType::kFloat32;
  EstimatorOptions estimator;
  bool names_counts = false;  // each result says of which neighbor_count it is
  NormalOptions normals;      // without the viewpoints of points, which come with them
  QuantitySet quantities;
  Direction curvature_direction{};  // (0, 0, 0): each point has its own, if normal curvature is asked for at all
  InvalidPointPolicy invalid_point_policy = InvalidPointPolicy::kReject;
  std::string request_tag;
  std::optional<JobPriority> priority;  // none: by the cloud's size
  CloudPart part;

  // What comes with the positions of points.
  bool has_normals() const { return normals.source != NormalSource::kEstimate; }
  bool has_viewpoints() const { return std::holds_alternative<SidesTowardViewpoints>(normals.sides); }
  bool has_directions() const {
    return quantities.Has(curvature::v1::QUANTITY_NORMAL_CURVATURE) && curvature_direction == Direction{};
  }
  // Bytes of one point in all arrays of a chunk.
  size_t point_bytes() const {
    const size_t arrays = 1 + (has_normals() ? 1 : 0) + (has_viewpoints() ? 1 : 0) + (has_directions() ? 1 : 0);
    return arrays * 3 * ScalarBytes(scalar_type) + (part.has_ids ? sizeof(uint64_t) : 0) + (part.has_roles ? 1 : 0);
  }
};

// The options that `header` asks for. Errors, each with its ErrorDetail:
// - INVALID_ARGUMENT: a field is out of its range.
// - RESOURCE_EXHAUSTED: point_count or a neighbor_count is over the limit of this server.
absl::StatusOr<CallOptions> ResolveHeader(const curvature::v1::CloudHeader& header, const CallLimits& limits);

// The smallest number of neighbors that a call asks for, or leaves open. None by radius, or where normals alone are
// asked for and their neighborhoods are left open.
std::optional<uint32_t> LeastNeighborCount(const CallOptions& options);

// The answer to a header that was resolved.
void FillAccepted(const CallOptions& options, const CallLimits& limits, const std::string& request_id,
                  curvature::v1::Accepted* accepted);

void FillLimits(const CallLimits& limits, curvature::v1::ServerLimits* proto);

// Every strategy that this server knows, in the order of the proto.
void FillEstimators(curvature::v1::GetServerInfoResponse* info);

}  // namespace curvd
