// Opens sockets that wait for connections.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace curvd {

// The sockets of one address, bound and listening, without blocking; closed on destruction. Movable, not thread-safe.
class ListeningSockets {
 public:
  // `address` is HOST:PORT, where a name with several addresses gets a socket for each and port 0 picks a free one, or
  // "unix:PATH". "0.0.0.0" is all of IPv4, "[::]" all of IPv4 and IPv6. A Unix socket that nobody listens on any more
  // is replaced. UNAVAILABLE, naming `flag` and the address, if it cannot be bound.
  static absl::StatusOr<ListeningSockets> Bind(const char* flag, const std::string& address);
  ~ListeningSockets();
  ListeningSockets(ListeningSockets&& other) noexcept;
  ListeningSockets& operator=(ListeningSockets&&) = delete;

  const std::vector<int>& descriptors() const { return descriptors_; }
  // 0 for a Unix socket.
  int port() const { return port_; }

 private:
  ListeningSockets() = default;
  // Each returns why it failed, or "".
  std::string BindUnix(const std::string& path);
  std::string BindTcp(const std::string& host, const std::string& port);

  std::vector<int> descriptors_;
  int port_ = 0;
  std::string unix_path_;  // removed in the end
};

}  // namespace curvd
