// Keeps the account of one RPC from its arrival to its end: who calls, what it moved, how it ended.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/support/status.h"
#include "server/access/access_control.h"
#include "server/access/caller.h"
#include "server/rpc/call_record.h"
#include "server/rpc/rpc_method.h"
#include "server/service_context.h"

namespace grpc {
class ServerContextBase;
}  // namespace grpc

namespace curvd {

// What is known of an RPC when it arrives.
struct RpcArrival {
  PresentedCredentials presented;
  uint64_t metadata_bytes = 0;  // as HTTP/2 counts them
  // DEFAULT: none.
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
};

RpcArrival ArrivalOf(const grpc::ServerContextBase& call);

// Every RPC of the service has one, from its arrival to its end, so that every RPC asks who calls, and is counted and
// logged in the same way. AnswerUnary and BidiStream make it for theirs. const methods are thread-safe. The others are
// not, save that CountReceived and CountSent may run at the same time, as the two sides of a stream do.
class RpcAccount {
 public:
  using Clock = std::chrono::steady_clock;

  // Counts the RPC as started, gives it its request id and finds out who calls. `service` must outlive this.
  RpcAccount(ServiceContext& service, RpcMethod method, const RpcArrival& arrival);
  RpcAccount(const RpcAccount&) = delete;
  RpcAccount& operator=(const RpcAccount&) = delete;

  // Who calls, or why the call is not let in: errors as AccessControl::Identify.
  const absl::StatusOr<Caller>& caller() const { return caller_; }
  const std::string& request_id() const { return record_.request_id; }
  Clock::time_point started() const { return started_; }

  // One message came, or goes out, with so many bytes.
  void CountReceived(uint64_t bytes);
  void CountSent(uint64_t bytes);

  // What metrics and log tell at the end, beside what this counts itself.
  CallRecord& record() { return record_; }
  const CallRecord& record() const { return record_; }

  // The error of a call whose caller has gone: DEADLINE_EXCEEDED if its deadline has passed, else CANCELLED. The
  // deadline counts from the arrival, on a clock that nobody sets.
  absl::Status CallerGoneNow() const;

  // `status` as the caller gets it.
  grpc::Status ToCaller(const absl::Status& status) const;

  // The RPC is over, with `status`: counts and logs it. REQUIRES: called once.
  void Close(absl::Status status);

 private:
  ServiceContext& service_;
  const Clock::time_point started_;
  const Clock::time_point deadline_;
  const absl::StatusOr<Caller> caller_;
  const uint64_t metadata_bytes_;
  uint64_t messages_ = 0;  // received
  CallRecord record_;
};

}  // namespace curvd
