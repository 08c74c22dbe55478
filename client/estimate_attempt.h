// One try of an estimate on one server.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/curvature_client.h"
#include "grpcpp/channel.h"

namespace curv {

struct AttemptFailure {
  absl::Status status;
  // Set if another try may succeed: how long to wait before it at least.
  std::optional<absl::Duration> retry_after;
  // Whether a server took part: one that is not there is no reason to wait long.
  bool answered = false;
};

struct AttemptOutcome {
  std::optional<CurvatureResult> result;
  AttemptFailure failure;  // if there is no result
};

// Sends the cloud and collects the results, reading while it writes: neither side can block the other, and an early
// refusal stops the sending. All of it on the calling thread: a hand-over between threads costs more than its message.
// REQUIRES: the arrays of `cloud` hold whole points, as many normals as positions.
AttemptOutcome RunAttempt(const std::shared_ptr<grpc::Channel>& channel, const CloudView& cloud,
                          const EstimateOptions& options, absl::Duration timeout, int attempt,
                          const EstimateCallbacks& callbacks);

}  // namespace curv
