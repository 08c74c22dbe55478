// Puts what gRPC itself has to say into curvd's log.
#pragma once

#include "server/observe/server_log.h"

namespace curvd {

// While this lives, the lines that gRPC would print on stderr become lines of `log` with the event "grpc", a few a
// second at most. Which lines gRPC prints stays as it is: errors, unless the environment variable GRPC_VERBOSITY asks
// for more. A setting of the process: for main. REQUIRES: there is one at a time, and `log` outlives it.
class GrpcLogRoute {
 public:
  explicit GrpcLogRoute(ServerLog& log);
  ~GrpcLogRoute();
  GrpcLogRoute(const GrpcLogRoute&) = delete;
  GrpcLogRoute& operator=(const GrpcLogRoute&) = delete;
};

}  // namespace curvd
