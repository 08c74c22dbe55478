// One try of an estimate on one server.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/curvature_client.h"
#include "curvature/v1/curvature.grpc.pb.h"

namespace curv {

struct AttemptFailure {
  absl::Status status;
  // Set if another try may succeed: how long to wait before it at least.
  std::optional<absl::Duration> retry_after;
};

struct AttemptOutcome {
  std::optional<CurvatureResult> result;
  AttemptFailure failure;  // if there is no result
};

// Sends the cloud and collects the results. The calling thread writes while another reads: neither side can block the
// other, and an early refusal stops the sending.
// REQUIRES: the arrays of `cloud` hold whole points, as many normals as positions.
AttemptOutcome RunAttempt(curvature::v1::CurvatureService::Stub& stub, const CloudView& cloud,
                          const EstimateOptions& options, absl::Duration timeout, int attempt,
                          const EstimateCallbacks& callbacks);

}  // namespace curv
