#include "server/curvature_service.h"

#include <chrono>

#include "core/cpu_kind.h"
#include "server/call_options.h"
#include "server/estimate_stream.h"
#include "server/version.h"

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
  response->set_version(Version());
  FillLimits(context_.limits, response->mutable_limits());
  FillEstimators(response);
  response->set_cpu_kind(CpuKind());
  response->set_worker_threads(static_cast<uint32_t>(context_.pool.thread_count()));
  context_.metrics.CountSent(RpcMethod::kGetServerInfo, response->ByteSizeLong());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  context_.metrics.CountHandled(RpcMethod::kGetServerInfo, absl::StatusCode::kOk, seconds.count());
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace curvd
