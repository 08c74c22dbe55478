// Serves the port where probes ask whether the server serves, and nothing else.
#pragma once

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/server.h>

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/net/connection_acceptor.h"
#include "server/net/connection_registry.h"

namespace curvd {

// grpc.health.v1 in plain text, for those who have neither a certificate nor a token: Kubernetes asks so. Whatever else
// is called is UNIMPLEMENTED. Serves until destroyed. Thread-safe.
class HealthPort {
 public:
  // `events` tells of connections as ConnectionAcceptor does; `memory` must outlive this. UNAVAILABLE, naming the
  // address, if it cannot be bound.
  static absl::StatusOr<std::unique_ptr<HealthPort>> Create(const std::string& listen, MemoryPressure& memory,
                                                            ConnectionAcceptor::Events events);
  ~HealthPort();

  int port() const { return acceptor_.port(); }
  // From now on, for good.
  void SetNotServing();

 private:
  HealthPort(ListeningSockets sockets, MemoryPressure& memory, ConnectionAcceptor::Events events);

  grpc::CallbackGenericService nothing_else_;
  std::unique_ptr<grpc::Server> server_;
  ConnectionRegistry connections_;
  ConnectionAcceptor acceptor_;
};

}  // namespace curvd
