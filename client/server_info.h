// What one server says about itself.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/curvature_client.h"

namespace curv {

// Asks for GetServerInfo and for the service's health. Errors are those of gRPC. A server without health service has
// health "UNKNOWN".
absl::StatusOr<ServerInfo> AskServer(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout);

// Asks for the service's health alone: "SERVING", "NOT_SERVING", ... Errors are those of gRPC.
absl::StatusOr<std::string> AskHealth(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout);

}  // namespace curv
