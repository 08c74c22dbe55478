// From gRPC's statuses, with their google.rpc details, to absl's.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "grpcpp/support/status.h"

namespace curv {

// Keeps code and message, and adds what ErrorInfo says and the message does not: "... [reason K_TOO_LARGE; limit
// 10000]". The reason is kept apart too, see ErrorReason. Damaged details are ignored, and control characters become
// '?': a server must not write on the caller's terminal, nor lines into its log.
absl::Status ToAbslStatus(const grpc::Status& status);

// How long to wait at least before the same call is tried again; nothing where trying again cannot help. RetryInfo says
// how long; UNAVAILABLE, and UNKNOWN and INTERNAL without ErrorInfo, which proxies make of a server that died, need no
// wait on another server.
std::optional<absl::Duration> RetryDelay(const grpc::Status& status);

}  // namespace curv
