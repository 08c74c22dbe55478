#include "server/call/curvature_service.h"

#include <chrono>

#include "core/base/cpu_kind.h"
#include "server/access/call_credentials.h"
#include "server/call/estimate_stream.h"
#include "server/call/header_options.h"
#include "server/host/version.h"
#include "server/rpc/grpc_status.h"

namespace curvd {

namespace v1 = curvature::v1;

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* CurvatureService::EstimateCurvature(
    grpc::CallbackServerContext* call) {
  return EstimateStream::Start(context_, *call);
}

grpc::ServerUnaryReactor* CurvatureService::GetServerInfo(grpc::CallbackServerContext* call,
                                                          const v1::GetServerInfoRequest* request,
                                                          v1::GetServerInfoResponse* response) {
  const auto start = std::chrono::steady_clock::now();
  context_.metrics.CountStarted(RpcMethod::kGetServerInfo);
  context_.metrics.CountReceived(RpcMethod::kGetServerInfo, request->ByteSizeLong());
  const absl::StatusOr<Caller> caller = context_.access.Identify(CredentialsOf(*call));
  if (caller.ok()) {
    FillServerInfo(*caller, response);
    context_.metrics.CountSent(RpcMethod::kGetServerInfo, response->ByteSizeLong());
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  context_.metrics.CountHandled(RpcMethod::kGetServerInfo, caller.status().code(), seconds.count());
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  reactor->Finish(caller.ok() ? grpc::Status::OK : Refuse(*call, caller.status()));
  return reactor;
}

void CurvatureService::FillServerInfo(const Caller& caller, v1::GetServerInfoResponse* response) const {
  response->set_version(Version());
  FillLimits(LimitsFor(caller, context_.limits), response->mutable_limits());
  FillEstimators(response);
  response->set_cpu_kind(CpuKind());
  response->set_worker_threads(static_cast<uint32_t>(context_.pool.thread_count()));
}

grpc::Status CurvatureService::Refuse(const grpc::CallbackServerContext& call, const absl::Status& status) {
  CallRecord record;
  record.request_id = context_.request_ids.Next();
  record.peer = call.peer();
  record.status = status;
  context_.metrics.CountCall(record);
  context_.log.LogCall(record);
  return ToGrpcStatus(status, record.request_id);
}

}  // namespace curvd
