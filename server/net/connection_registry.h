// Knows every open connection: who made it, when, what it has sent, and whether a call was let in from it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/net/byte_account.h"
#include "server/observe/security_metrics.h"

namespace curvd {

// What is known of one connection.
struct ConnectionRecord {
  std::string peer;                                // as gRPC writes it: "ipv4:10.0.0.7:1234"
  std::chrono::steady_clock::time_point accepted;  // when it came
  // Bytes that TCP has received from the peer, TLS and HTTP/2 included. TCP counts the end of what a peer sends as one
  // byte more. 0 for a Unix socket.
  uint64_t received_bytes = 0;
  uint64_t let_in_bytes = 0;                 // of them, bytes of messages of calls that were let in
  uint64_t let_in_calls = 0;                 // calls that access control let in
  uint64_t refused_calls = 0;                // calls that it did not let in
  uint64_t open_calls = 0;                   // calls that everybody may make: health, and reflection where it is on
  std::optional<StrangerReason> closed_for;  // why the guard ended it, if it did
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

  explicit ConnectionRegistry(const ByteAllowances& allowances = {}) : allowances_(allowances) {}
  // Closes the watches that are left.
  ~ConnectionRegistry();
  ConnectionRegistry(const ConnectionRegistry&) = delete;
  ConnectionRegistry& operator=(const ConnectionRegistry&) = delete;

  // Adds the connection whose socket is `fd`; `peer` is as gRPC writes it. Where the system can, it receives from now
  // on no more than what ByteAllowances let a stranger send, until a call is let in. Returns its watch, or -1 with
  // errno set if the system has no descriptor left. REQUIRES: `fd` is an open socket.
  int Add(int fd, const std::string& peer);
  // Forgets the connection, closes its watch, and returns what is known of it. REQUIRES: Add returned `watch`, and it
  // was not removed since.
  ConnectionRecord Remove(int watch);
  // Removes all.
  void Clear();

  // A call with `metadata` bytes of metadata came from `peer`; or a message of `bytes` bytes of a call that was let in,
  // or one was sent to it; or a call is over that was let in, or one that everybody may make; or one that was not let
  // in got its answer, and was not broken off. No effect if no connection of that peer is known: calls in the same
  // process have none, and those from Unix sockets cannot be told apart.
  void NoteCall(const std::string& peer, Call call, uint64_t metadata);
  void NoteMessage(const std::string& peer, uint64_t bytes, bool is_first);
  void NoteSent(const std::string& peer, uint64_t bytes);
  void NoteEnd(const std::string& peer, const EndedCall& call);
  void NoteOpenToAllEnd(const std::string& peer);
  void NoteAnswered(const std::string& peer, uint64_t metadata);

  // What strangers have sent, as far as it was seen by Look: of each connection of which no call was let in, what it
  // has sent that its answered calls and pings do not account for, beyond ByteAllowances::first_flight.
  uint64_t StrangersBytes() const;
  // Who has sent no more than a TLS handshake and a call beside that is spared even where memory is short, unless
  // there are many of them.
  static constexpr uint64_t kSparedBytes = ByteAccount::kSmallBytes;
  // What a look at a connection shows.
  enum class Sight {
    kQuiet,  // nothing came since the last look
    kOwes,   // the same, but if it stays so, the connection is to be ended some seconds later
    kBusy,   // bytes came, or it has sent so many that it may be ended soon
    kEnded,  // it had sent too many, and was ended now
  };
  // Whether bytes came since the last look, or since the connection was added. REQUIRES: as Remove.
  bool HasMore(int watch) const;
  // Looks at what the connection has sent until `now`, and ends it if that is too much. REQUIRES: as Remove; `now` does
  // not go back.
  Sight Look(int watch, ByteAccount::Clock::time_point now);
  // Whether no call was let in from the connection. REQUIRES: as Remove.
  bool IsStranger(int watch) const;
  // Of those of which no call was let in, ends the connection that has sent most that nothing accounts for, if that is
  // more than kSparedBytes. Returns whether there was one.
  bool EndLargestStranger();
  // Of those of which no call was let in, ends the largest until the others together have sent at most `together` bytes
  // that nothing accounts for. Returns whether it ended any.
  bool EndStrangersBeyond(uint64_t together);
  // Ends the connection of which a call was let in, and of whose bytes most were unaccounted for at its last look, if
  // more than `least`. Returns whether there was one.
  bool EndLargestLetIn(uint64_t least);

  size_t size() const;
  // Connections from `address`, which is a PeerAddress.
  size_t CountFrom(const std::string& address) const;
  // What is known of each open connection, in no order, with the bytes that it has sent until now.
  std::vector<ConnectionRecord> Open() const;
  // Ends the connection of `peer` in both directions; gRPC notices as if the peer had hung up. Returns whether there
  // was one.
  bool ShutDown(const std::string& peer);

 private:
  struct Connection {
    ConnectionRecord record;
    ByteAccount account;
    std::optional<uint32_t> beginning;  // where its bytes begin, while the system bounds them
    uint64_t bound = 0;                 // the bytes that the system lets through
    uint64_t unaccounted = 0;           // at the last look, with what gRPC had not read
    // It has sent as much, and calls of it were answered meanwhile: only who sends calls as fast as he can comes there.
    bool was_full = false;
  };

  static uint64_t BytesBeyond(uint64_t spared, const Connection& connection);
  // What the connection adds to StrangersBytes.
  uint64_t StrangersBytesOf(const Connection& connection) const;
  Connection* Find(const std::string& peer) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Ends it, and throws away what gRPC has not read.
  void End(int watch, Connection& connection, StrangerReason reason) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Has the system let through what the account allows.
  void MoveBound(int watch, Connection& connection) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ByteAllowances allowances_;
  mutable Mutex mutex_;
  std::unordered_map<int, Connection> connections_ ABSL_GUARDED_BY(mutex_);     // by watch
  std::unordered_map<std::string, int> watch_of_peer_ ABSL_GUARDED_BY(mutex_);  // the latest, if there were several
  std::unordered_map<std::string, size_t> count_by_address_ ABSL_GUARDED_BY(mutex_);
  uint64_t strangers_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace curvd
