// What gRPC writes to its own log, which is the only place where it tells of handshakes that failed.
#pragma once

#include <functional>
#include <string>

namespace curvd {

// While one of these lives, gRPC's lines go to it, down to those for debugging, instead of stderr; where several live,
// to each. Thread-safe.
class GrpcLogTap {
 public:
  // `file` is the source file without its folder; `is_shown`: gRPC would have printed the line. Called on any thread,
  // maybe with locks of gRPC held: it must not block and not call gRPC.
  using Listener = std::function<void(const std::string& file, const std::string& message, bool is_shown)>;

  explicit GrpcLogTap(Listener listener);
  ~GrpcLogTap();
  GrpcLogTap(const GrpcLogTap&) = delete;
  GrpcLogTap& operator=(const GrpcLogTap&) = delete;

 private:
  friend struct GrpcLogTaps;
  const Listener listener_;
};

}  // namespace curvd
