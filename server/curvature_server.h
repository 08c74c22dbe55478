// curvd as a library: the gRPC service with its worker pool, limits, health, reflection and metrics.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/server_options.h"

namespace grpc {
class Channel;
}  // namespace grpc

namespace curvd {

// A running server. Thread-safe. Several may live in one process.
class CurvatureServer {
 public:
  // Starts a server that is bound and serving when this returns. Errors:
  // - INVALID_ARGUMENT: options.Validate() failed, or a file of certificates, tokens or names is not what it should be.
  // - UNAVAILABLE: an address cannot be bound (in use, no permission, not an address), or such a file cannot be read;
  //   the message names it.
  static absl::StatusOr<std::unique_ptr<CurvatureServer>> Create(const ServerOptions& options);

  // Stops hard: open calls end with UNAVAILABLE or CANCELLED at once. Call Drain first to be polite.
  ~CurvatureServer();
  CurvatureServer(const CurvatureServer&) = delete;
  CurvatureServer& operator=(const CurvatureServer&) = delete;

  // The bound TCP ports; 0 where there is none.
  int port() const;
  int health_port() const;
  int metrics_port() const;

  // A channel to this server that uses no socket. Messages up to the server's own sizes pass both ways.
  // REQUIRES: no call is started on it once the server is destroyed (gRPC would crash); after Drain they get
  // UNAVAILABLE.
  std::shared_ptr<grpc::Channel> InProcessChannel();

  // Ends politely: health says NOT_SERVING, new streams get UNAVAILABLE, accepted ones may finish within `timeout`, the
  // rest end with UNAVAILABLE that says so, then the server stops. Returns when it has stopped. A second call waits for
  // the first.
  void Drain(absl::Duration timeout);

  // Returns when Drain has stopped the server.
  void Wait();

 private:
  class Running;
  explicit CurvatureServer(std::unique_ptr<Running> running);

  std::unique_ptr<Running> running_;
};

}  // namespace curvd
