// The RPCs of curvature.v1.CurvatureService.
#pragma once

#include "curvature/v1/curvature.grpc.pb.h"
#include "server/service_context.h"

namespace curvd {

// EstimateCurvature takes and gives messages as bytes, see BidiStream.
using CurvatureServiceBase = curvature::v1::CurvatureService::WithRawCallbackMethod_EstimateCurvature<
    curvature::v1::CurvatureService::WithCallbackMethod_GetServerInfo<curvature::v1::CurvatureService::Service>>;

// Each RPC is one function here: GrpcBidiReactor serves a stream, AnswerUnary an RPC of one message each way, and both
// find out who calls, and count and log the call. Thread-safe.
class CurvatureService final : public CurvatureServiceBase {
 public:
  // `context` must outlive the service and its calls.
  explicit CurvatureService(ServiceContext& context) : context_(context) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* EstimateCurvature(
      grpc::CallbackServerContext* call) override;

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* call,
                                          const curvature::v1::GetServerInfoRequest* request,
                                          curvature::v1::GetServerInfoResponse* response) override;

 private:
  void FillServerInfo(const Caller& caller, curvature::v1::GetServerInfoResponse& response) const;

  ServiceContext& context_;
};

}  // namespace curvd
