// Turns an absl::Status into gRPC's, at the edge of the server.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace curvd {

// `status` as callers get it: the same code, the message with the request id behind it, and a google.rpc.Status with
// the attached details (ErrorInfo always, with the request id in its metadata) in the error details.
grpc::Status ToGrpcStatus(const absl::Status& status, const std::string& request_id);

// The name of a code in metrics and logs, as gRPC spells it: "OK", "INVALID_ARGUMENT", ...
std::string CodeName(absl::StatusCode code);

}  // namespace curvd
