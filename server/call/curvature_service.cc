#include "server/call/curvature_service.h"

#include "core/base/cpu_kind.h"
#include "server/call/estimate_call.h"
#include "server/call/header_options.h"
#include "server/host/version.h"
#include "server/rpc/grpc_bidi_reactor.h"
#include "server/rpc/unary_rpc.h"

namespace curvd {

namespace v1 = curvature::v1;

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* CurvatureService::EstimateCurvature(
    grpc::CallbackServerContext* call) {
  return GrpcBidiReactor::Serve<EstimateCall>(context_, *call);
}

grpc::ServerUnaryReactor* CurvatureService::GetServerInfo(grpc::CallbackServerContext* call,
                                                          const v1::GetServerInfoRequest* request,
                                                          v1::GetServerInfoResponse* response) {
  return AnswerUnary<v1::GetServerInfoRequest, v1::GetServerInfoResponse>(
      context_, RpcMethod::kGetServerInfo, *call, *request, *response,
      [this](const Caller& caller, v1::GetServerInfoResponse& info) {
        FillServerInfo(caller, info);
        return absl::OkStatus();
      });
}

void CurvatureService::FillServerInfo(const Caller& caller, v1::GetServerInfoResponse& response) const {
  response.set_version(Version());
  FillLimits(LimitsFor(caller, context_.limits), response.mutable_limits());
  FillEstimators(&response);
  response.set_cpu_kind(CpuKind());
  response.set_worker_threads(static_cast<uint32_t>(context_.pool.thread_count()));
}

}  // namespace curvd
