// Where a client's calls go: a channel for each server.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/connect_options.h"
#include "client/curvature_client.h"
#include "grpcpp/channel.h"

namespace curv {

// Thread-safe.
class CurvatureClient::Channels {
 public:
  // See CurvatureClient::Connect.
  static absl::StatusOr<std::unique_ptr<Channels>> Create(std::string_view servers, const ConnectOptions& options);
  Channels(std::vector<std::shared_ptr<grpc::Channel>> channels, size_t start)
      : channels_(std::move(channels)), next_(start) {}

  // Takes turns, starting with any.
  const std::shared_ptr<grpc::Channel>& Next() { return channels_[next_++ % channels_.size()]; }
  size_t size() const { return channels_.size(); }
  // Whether they lead to servers that they connect to themselves. A channel that was given may be that of a server in
  // this process, which has no connection: gRPC ends a process that waits for it.
  bool connect() const { return connect_; }
  // Whether any server has ever answered.
  bool reached() const { return reached_; }
  void SetReached() { reached_ = true; }
  // See ExplainConnectError.
  absl::Status Explain(const absl::Status& status) const { return ExplainConnectError(status, tls_, has_certificate_); }

 private:
  std::vector<std::shared_ptr<grpc::Channel>> channels_;
  std::atomic<size_t> next_;
  std::atomic<bool> reached_ = false;
  bool connect_ = false;
  bool tls_ = false;
  bool has_certificate_ = false;
};

}  // namespace curv
