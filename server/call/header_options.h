// Resolves what a CloudHeader asks for: checks it, and fills in every default.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/cloud/cloud.h"
#include "core/estimators/options.h"
#include "core/job/worker_pool.h"
#include "curvature/v1/curvature.pb.h"
#include "server/call/request_limits.h"

namespace curvd {

// Quantities that the results carry, beside the status. DEFAULT: all that the contract knows.
class QuantitySet {
 public:
  static QuantitySet None() { return QuantitySet(0); }
  QuantitySet() = default;

  void Add(curvature::v1::Quantity quantity) { bits_ |= BitOf(quantity); }
  bool Has(curvature::v1::Quantity quantity) const { return (bits_ & BitOf(quantity)) != 0; }

 private:
  static_assert(curvature::v1::Quantity_ARRAYSIZE <= 64);
  explicit QuantitySet(uint64_t bits) : bits_(bits) {}
  static uint64_t BitOf(curvature::v1::Quantity quantity) { return uint64_t{1} << quantity; }

  uint64_t bits_ = ~uint64_t{0};
};

struct CallOptions {
  uint64_t point_count = 0;       // 0: unknown
  bool marks_last_chunk = false;  // a cloud without a marked chunk is incomplete
  ScalarType scalar_type = ScalarType::kFloat32;
  EstimatorOptions estimator;
  QuantitySet quantities;
  InvalidPointPolicy invalid_point_policy = InvalidPointPolicy::kReject;
  std::string request_tag;
  std::optional<JobPriority> priority;  // none: by the cloud's size
};

// The options that `header` asks for. Errors, each with its ErrorDetail:
// - INVALID_ARGUMENT: a field is out of its range.
// - RESOURCE_EXHAUSTED: point_count or neighbor_count is over the limit of this server.
absl::StatusOr<CallOptions> ResolveHeader(const curvature::v1::CloudHeader& header, const CallLimits& limits);

// The answer to a header that was resolved.
void FillAccepted(const CallOptions& options, const CallLimits& limits, const std::string& request_id,
                  curvature::v1::Accepted* accepted);

void FillLimits(const CallLimits& limits, curvature::v1::ServerLimits* proto);

// Every strategy that this server knows, in the order of the proto.
void FillEstimators(curvature::v1::GetServerInfoResponse* info);

}  // namespace curvd
