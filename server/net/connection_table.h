// Which connections are open, of whom.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <unordered_map>

namespace curvd {

// gRPC owns the sockets and tells nobody when it closes one. So the table remembers each socket's descriptor and inode,
// and looks whether the descriptor still leads to it. Not thread-safe.
class ConnectionTable {
 public:
  // `peer` is as gRPC writes it. REQUIRES: `fd` is open.
  void Add(int fd, const std::string& peer);
  // Forgets what has been closed; about half a microsecond for each connection.
  void Sweep();

  // Of those that were open at the last sweep.
  size_t size() const { return connections_.size(); }
  // `address` is a PeerAddress.
  size_t CountOf(const std::string& address) const;

  // The peer of the one TCP connection that this process has shut down, or that broke, and that is not closed yet;
  // empty if there is none or more than one. Takes about as long as two sweeps.
  std::string PeerBeingClosed() const;

 private:
  struct Connection {
    dev_t device;
    ino_t inode;
    std::string peer;
  };
  static bool IsOpen(int fd, const Connection& connection);
  void Remove(std::unordered_map<int, Connection>::iterator connection);

  std::unordered_map<int, Connection> connections_;  // by descriptor
  std::unordered_map<std::string, size_t> count_by_address_;
};

}  // namespace curvd
