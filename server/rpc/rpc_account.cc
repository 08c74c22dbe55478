#include "server/rpc/rpc_account.h"

#include <grpcpp/server_context.h>

#include <utility>

#include "server/access/call_credentials.h"
#include "server/net/open_calls.h"
#include "server/rpc/ending_errors.h"
#include "server/rpc/grpc_status.h"

namespace curvd {
namespace {

// The caller's clock started before ours, so that its cancel may arrive a little before our deadline.
constexpr auto kDeadlineSlack = std::chrono::milliseconds(50);

// When `deadline` comes, given that it is `now`.
RpcAccount::Clock::time_point OnSteadyClock(std::chrono::system_clock::time_point deadline,
                                            RpcAccount::Clock::time_point now) {
  if (deadline == std::chrono::system_clock::time_point::max()) return RpcAccount::Clock::time_point::max();
  return now + (deadline - std::chrono::system_clock::now());
}

}  // namespace

RpcArrival ArrivalOf(const grpc::ServerContextBase& call) {
  return {CredentialsOf(call), MetadataBytes(call), call.deadline()};
}

RpcAccount::RpcAccount(ServiceContext& service, RpcMethod method, const RpcArrival& arrival)
    : service_(service),
      started_(Clock::now()),
      deadline_(OnSteadyClock(arrival.deadline, started_)),
      caller_(service.LetIn(arrival.presented, arrival.metadata_bytes)),
      metadata_bytes_(arrival.metadata_bytes) {
  record_.method = method;
  record_.request_id = service.request_ids.Next();
  record_.peer = arrival.presented.peer;
  if (caller_.ok()) record_.caller = caller_->name;
  service.metrics.CountStarted(method);
}

void RpcAccount::CountReceived(uint64_t bytes) {
  record_.bytes_received += bytes;
  service_.metrics.CountReceived(record_.method, bytes);
  if (caller_.ok()) service_.connections.NoteMessage(record_.peer, bytes, ++messages_ == 1);
}

void RpcAccount::CountSent(uint64_t bytes) {
  record_.bytes_sent += bytes;
  service_.metrics.CountSent(record_.method, bytes);
  if (caller_.ok()) service_.connections.NoteSent(record_.peer, bytes);
}

absl::Status RpcAccount::CallerGoneNow() const { return CallerGone(Clock::now() + kDeadlineSlack >= deadline_); }

grpc::Status RpcAccount::ToCaller(const absl::Status& status) const { return ToGrpcStatus(status, request_id()); }

void RpcAccount::Close(absl::Status status) {
  record_.status = std::move(status);
  record_.total_seconds = std::chrono::duration<double>(Clock::now() - started_).count();
  service_.metrics.CountHandled(record_.method, record_.status.code(), record_.total_seconds);
  service_.metrics.CountCall(record_);
  service_.log.LogCall(record_);
  const bool is_gone = absl::IsCancelled(record_.status) || absl::IsDeadlineExceeded(record_.status);
  if (caller_.ok()) {
    service_.connections.NoteEnd(record_.peer, {metadata_bytes_, messages_, is_gone});
  } else if (!is_gone) {
    service_.connections.NoteAnswered(record_.peer, metadata_bytes_);
  }
}

}  // namespace curvd
