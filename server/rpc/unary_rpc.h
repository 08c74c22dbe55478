// Serves an RPC of one message each way.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "proto/http_date.h"
#include "server/rpc/rpc_account.h"

namespace curvd {

// Answers an RPC whose answer is at hand: finds out who calls, lets `answer` fill `response` for a caller that is let
// in, or say with an error why not, and counts and logs the call. Answers come with the server's time
// (proto/http_date.h). `answer` must not block.
template <typename Request, typename Response>
grpc::ServerUnaryReactor* AnswerUnary(ServiceContext& service, RpcMethod method, grpc::CallbackServerContext& call,
                                      const Request& request, Response& response,
                                      absl::FunctionRef<absl::Status(const Caller&, Response&)> answer) {
  RpcAccount account(service, method, ArrivalOf(call));
  account.CountReceived(request.ByteSizeLong());
  const absl::Status status = account.caller().ok() ? answer(*account.caller(), response) : account.caller().status();
  if (status.ok()) {
    account.CountSent(response.ByteSizeLong());
    call.AddInitialMetadata(kDateHeader, FormatHttpDate(absl::Now()));
  }
  account.Close(status);
  grpc::ServerUnaryReactor* reactor = call.DefaultReactor();
  reactor->Finish(account.ToCaller(status));
  return reactor;
}

}  // namespace curvd
