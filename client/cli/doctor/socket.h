// Opens connections without gRPC, which tells of failures in few words.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/name_lookup.h"

namespace curv {

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
