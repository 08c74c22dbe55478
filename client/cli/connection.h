// Where a command's calls go: a server on the network, or one in this process.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "client/cli/connection_flags.h"
#include "client/curvature_client.h"

namespace curv {

class Connection {
 public:
  // To flags.server (see CurvatureClient::Connect), or, if that is empty, to a server of its own with `threads` workers
  // (0: one a core) that is reached through the same gRPC service, without a socket. INVALID_ARGUMENT: the flags name
  // no list of servers, or do not fit together. Other errors: no server could be started.
  static absl::StatusOr<std::unique_ptr<Connection>> Create(const ConnectionFlags& flags, int threads);
  virtual ~Connection() = default;

  virtual const CurvatureClient& client() const = 0;
};

}  // namespace curv
