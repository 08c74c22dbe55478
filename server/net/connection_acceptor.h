// Takes connections and hands them to gRPC, up to a limit.
#pragma once

#include <grpcpp/server_builder.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/net/connection_table.h"
#include "server/net/listening_socket.h"
#include "server/observe/security_metrics.h"

namespace curvd {

struct ConnectionLimits {
  size_t max_connections = 0;
  size_t max_per_peer = 0;  // from one address, see PeerAddress
};

// gRPC 1.51 takes any number of connections, and stops listening for good once the process has no descriptor left. So a
// thread of ours accepts, closes what is over a limit right away, and gives the rest to gRPC. Thread-safe.
class ConnectionAcceptor {
 public:
  // Told of each connection that was closed at once. Called on the acceptor's thread; must not block.
  using OnRefused = std::function<void(StrangerReason reason, const std::string& peer)>;

  ConnectionAcceptor(ListeningSockets sockets, const ConnectionLimits& limits, OnRefused on_refused);
  // Stops first.
  ~ConnectionAcceptor();
  ConnectionAcceptor(const ConnectionAcceptor&) = delete;
  ConnectionAcceptor& operator=(const ConnectionAcceptor&) = delete;

  int port() const { return sockets_.port(); }

  // Connections go to `target` from now on; those that came before have waited. REQUIRES: the server of `target` runs
  // until Stop. Called once.
  void Start(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target);
  // Accepts nothing more. Connections that are open stay so.
  void Stop();

  // Connections that are open now.
  size_t OpenCount();
  // See ConnectionTable.
  std::string PeerBeingClosed();

 private:
  void Run();
  void AcceptAll(int listener);
  // Whether a connection from `peer` is within the limits; it is in the table then, else `reason` says why not.
  bool MayStay(int fd, const std::string& peer, StrangerReason& reason);

  const ListeningSockets sockets_;
  const ConnectionLimits limits_;
  const OnRefused on_refused_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target_;
  int wake_fd_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
  Mutex mutex_;
  ConnectionTable table_ ABSL_GUARDED_BY(mutex_);
  std::chrono::steady_clock::time_point swept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
