// Looks up names and opens connections without gRPC, which tells of failures in few words.
#pragma once

#include <netinet/in.h>

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace curv {

struct Address {
  sockaddr_storage bytes = {};
  socklen_t size = 0;
  std::string text;  // "127.0.0.1:50061", "[::1]:50061"
};

// The addresses of a host in the order in which the system prefers them, each once. NOT_FOUND, with the system's words,
// if it has none. `port` is a number.
absl::StatusOr<std::vector<Address>> LookUp(const std::string& host, const std::string& port);

// A connection that is closed with its owner. Reads and writes wait for at most the time that it was opened with.
class Socket {
 public:
  // UNAVAILABLE if the other side refuses, DEADLINE_EXCEEDED if nothing comes back in time, UNKNOWN with the system's
  // words for all else.
  static absl::StatusOr<Socket> Connect(const Address& address, absl::Duration timeout);
  Socket(Socket&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  Socket& operator=(Socket&&) = delete;
  ~Socket();

  int descriptor() const { return descriptor_; }
  // Whether all of it was sent.
  bool Send(std::string_view bytes) const;
  // The first bytes that come, at least `least` unless the other side ends before; fewer when time is over, too.
  std::string Receive(size_t least) const;

 private:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace curv
