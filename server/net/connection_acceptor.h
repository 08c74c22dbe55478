// Takes connections, hands them to gRPC up to a limit, and notices when each of them ends.
#pragma once

#include <grpcpp/server_builder.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>

#include "server/net/connection_guard.h"
#include "server/net/connection_registry.h"
#include "server/net/listening_socket.h"
#include "server/observe/security_metrics.h"

namespace curvd {

struct ConnectionLimits {
  size_t max_connections = 0;
  size_t max_per_peer = 0;  // from one address, see PeerAddress
};

// gRPC 1.51 takes any number of connections, and stops listening for good once the process has no descriptor left. So a
// thread of ours accepts, closes what is over a limit right away, and gives the rest to gRPC. The same thread polls the
// watches of the registry, so that the end of a connection is noticed at once, and has the guard look at connections
// from which bytes come. Thread-safe.
class ConnectionAcceptor {
 public:
  // What the acceptor tells of, on its thread. Neither function may block; either may be null.
  struct Events {
    // A connection from `peer` was closed at once, for `reason`; `peer` is empty if it could not even be taken.
    std::function<void(StrangerReason reason, const std::string& peer)> refused;
    // A connection ended after `age`, whoever ended it. Connections that are open when the acceptor stops are not told.
    std::function<void(const ConnectionRecord& connection, std::chrono::steady_clock::duration age)> ended;
  };

  // `connections` gets the connections that are open; nobody else may add to it. It and `memory` must outlive this.
  ConnectionAcceptor(ListeningSockets sockets, const ConnectionLimits& limits, ConnectionRegistry& connections,
                     MemoryPressure& memory, Events events);
  // Stops first.
  ~ConnectionAcceptor();
  ConnectionAcceptor(const ConnectionAcceptor&) = delete;
  ConnectionAcceptor& operator=(const ConnectionAcceptor&) = delete;

  int port() const { return sockets_.port(); }

  // Connections go to `target` from now on; those that came before have waited. REQUIRES: the server of `target` runs
  // until Stop. Called once.
  void Start(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target);
  // Accepts nothing more. Connections that are open stay so, but the registry forgets them.
  void Stop();

 private:
  void Run();
  // Takes what waits at `listener`, up to a number that lets ended connections have their turn.
  void AcceptSome(int listener);
  // Hands the connection over, closes it, or has it wait at the door.
  void Receive(int listener, int fd, const std::string& peer);
  void HandOver(int listener, int fd);
  void RemoveEnded(int watch);
  // The guard takes its turn, if it is due.
  void Guard();
  bool IsListener(int fd) const;
  // Whether one more connection from `peer` is within the limits; else `reason` says why not.
  bool MayStay(const std::string& peer, StrangerReason& reason) const;
  void Refuse(StrangerReason reason, const std::string& peer) const;

  const ListeningSockets sockets_;
  const ConnectionLimits limits_;
  ConnectionRegistry& connections_;
  ConnectionGuard guard_;
  const Events events_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target_;
  // A connection that gRPC does not have yet, since there is no ration for what it has sent.
  struct AtDoor {
    int listener;
    int fd;
  };
  std::unordered_map<int, AtDoor> at_door_;  // by watch
  int epoll_fd_;
  int wake_fd_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace curvd
