// Connects a command to the server that its calls go to, on the network or in this process.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "absl/status/statusor.h"
#include "client/cli/connection_flags.h"
#include "client/cli/progress_bar.h"
#include "client/curvature_client.h"
#include "client/io/oriented_cloud.h"

namespace curv {

class Connection {
 public:
  // Connects to flags.server (see CurvatureClient::Connect). If that is empty, starts a server in this process with
  // `threads` workers (0: one a core), which is reached through the same gRPC service without a socket.
  // INVALID_ARGUMENT if the flags name no list of servers or do not fit together; other errors if no server could be
  // started.
  static absl::StatusOr<std::unique_ptr<Connection>> Create(const ConnectionFlags& flags, int threads);
  virtual ~Connection() = default;

  virtual const CurvatureClient& client() const = 0;
};

// Sends a cloud as CurvatureClient::Estimate does, and shows a progress bar meanwhile.
absl::StatusOr<CurvatureResult> CallServer(const Connection& connection, const OrientedCloud& cloud,
                                           const EstimateOptions& options, const std::stop_token& stop,
                                           const std::optional<BatchShare>& share = std::nullopt);

}  // namespace curv
