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
#include "server/net/stranger_rations.h"
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

  explicit ConnectionRegistry(const ByteAllowances& allowances = {})
      : allowances_(allowances), rations_(allowances.stranger, allowances.call()) {}
  // Closes the watches that are left.
  ~ConnectionRegistry();
  ConnectionRegistry(const ConnectionRegistry&) = delete;
  ConnectionRegistry& operator=(const ConnectionRegistry&) = delete;

  // A connection that was added.
  struct Added {
    int watch;
    bool may_enter;  // now; else DivideAmongStrangers will tell
  };
  // Adds the connection whose socket is `fd`; `peer` is as gRPC writes it. Where the system can, it receives from now
  // on no more than its ration, until a call is let in; see StrangerRations. nullopt, with errno set, if the system has
  // no descriptor left. REQUIRES: `fd` is an open socket.
  std::optional<Added> Add(int fd, const std::string& peer);
  // Forgets the connection, closes its watch, and returns what is known of it. REQUIRES: Add gave `watch`, and it
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
  // Strangers may send so many bytes together from now on that nothing accounts for, or what one of them needs if that
  // is more. DEFAULT: without bound.
  void ShareAmongStrangers(uint64_t bytes);
  // Gives more to strangers who have sent what they may, and ends one for their sake if there is nothing left; see
  // StrangerRations. REQUIRES: `now` does not go back.
  struct Division {
    std::vector<int> enter;  // watches of connections that may enter now
    bool ended = false;      // whether it ended one
  };
  Division DivideAmongStrangers(ByteAccount::Clock::time_point now);
  // Ends the connection of which a call was let in, and of whose bytes most were unaccounted for at its last look, if
  // more than `least`. Returns whether there was one.
  bool EndLargestLetIn(uint64_t least);

  size_t size() const;
  // Connections from `address`, which is a PeerAddress.
  size_t CountFrom(const std::string& address) const;
  // What is known of each open connection, in no order, with the bytes that it has sent until now.
  std::vector<ConnectionRecord> Open() const;

 private:
  struct Connection {
    ConnectionRecord record;
    ByteAccount account;
    uint64_t unaccounted = 0;  // at the last look, with what gRPC had not read
  };

  static uint64_t BytesBeyond(uint64_t spared, const Connection& connection);
  Connection* Find(const std::string& peer) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Ends it, and throws away what gRPC has not read.
  void End(int watch, Connection& connection, StrangerReason reason) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ByteAllowances allowances_;
  mutable Mutex mutex_;
  std::unordered_map<int, Connection> connections_ ABSL_GUARDED_BY(mutex_);     // by watch
  std::unordered_map<std::string, int> watch_of_peer_ ABSL_GUARDED_BY(mutex_);  // the latest, if there were several
  std::unordered_map<std::string, size_t> count_by_address_ ABSL_GUARDED_BY(mutex_);
  StrangerRations rations_ ABSL_GUARDED_BY(mutex_);  // by watch
};

}  // namespace curvd
