// Knows every open connection: who made it, when, what it has sent, and whether a call was let in from it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// What is known of one connection.
struct ConnectionRecord {
  std::string peer;                                // as gRPC writes it: "ipv4:10.0.0.7:1234"
  std::chrono::steady_clock::time_point accepted;  // when it came
  // Bytes that TCP has received from the peer, TLS and HTTP/2 included. TCP counts the end of what a peer sends as one
  // byte more. 0 for a Unix socket.
  uint64_t received_bytes = 0;
  uint64_t let_in_bytes = 0;   // of them, bytes of messages of calls that were let in
  uint64_t let_in_calls = 0;   // calls that access control let in
  uint64_t refused_calls = 0;  // calls that it did not let in
  uint64_t open_calls = 0;     // calls that everybody may make: health, and reflection where it is on
};

// gRPC owns the sockets and tells nobody when it closes one. So the registry keeps a second descriptor of each socket,
// the watch. gRPC shuts a socket down before it closes its own descriptor, and then the watch shows EPOLLHUP, as it
// does when the peer breaks the connection off; whoever polls the watches removes it then, which closes the socket for
// good. Through its watch a connection can be asked or shut down at any time: the number cannot have become that of
// another file. Thread-safe.
class ConnectionRegistry {
 public:
  // How a call was received.
  enum class Call { kLetIn, kRefused, kOpenToAll };

  ConnectionRegistry() = default;
  // Closes the watches that are left.
  ~ConnectionRegistry();
  ConnectionRegistry(const ConnectionRegistry&) = delete;
  ConnectionRegistry& operator=(const ConnectionRegistry&) = delete;

  // Adds the connection whose socket is `fd`; `peer` is as gRPC writes it. Returns its watch, or -1 with errno set if
  // the system has no descriptor left. REQUIRES: `fd` is an open socket.
  int Add(int fd, const std::string& peer);
  // Forgets the connection, closes its watch, and returns what is known of it. REQUIRES: Add returned `watch`, and it
  // was not removed since.
  ConnectionRecord Remove(int watch);
  // Removes all.
  void Clear();

  // A call came from `peer`, or a message of `bytes` bytes of a call that was let in. No effect if no connection of
  // that peer is known: calls in the same process have none, and those from Unix sockets cannot be told apart.
  void NoteCall(const std::string& peer, Call call);
  void NoteMessage(const std::string& peer, uint64_t bytes);

  size_t size() const;
  // Connections from `address`, which is a PeerAddress.
  size_t CountFrom(const std::string& address) const;
  // What is known of each open connection, in no order, with the bytes that it has sent until now.
  std::vector<ConnectionRecord> Open() const;
  // Ends the connection of `peer` in both directions; gRPC notices as if the peer had hung up. Returns whether there
  // was one.
  bool ShutDown(const std::string& peer);

 private:
  ConnectionRecord* Find(const std::string& peer) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  std::unordered_map<int, ConnectionRecord> connections_ ABSL_GUARDED_BY(mutex_);  // by watch
  std::unordered_map<std::string, int> watch_of_peer_ ABSL_GUARDED_BY(mutex_);     // the latest, if there were several
  std::unordered_map<std::string, size_t> count_by_address_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
