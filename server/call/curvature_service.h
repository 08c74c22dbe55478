// The RPCs of curvature.v1.CurvatureService.
#pragma once

#include "curvature/v1/curvature.grpc.pb.h"
#include "server/service_context.h"

namespace curvd {

// EstimateCurvature takes and gives messages as bytes, see EstimateStream.
using CurvatureServiceBase = curvature::v1::CurvatureService::WithRawCallbackMethod_EstimateCurvature<
    curvature::v1::CurvatureService::WithCallbackMethod_GetServerInfo<curvature::v1::CurvatureService::Service>>;

// Thread-safe.
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
  void FillServerInfo(const Caller& caller, curvature::v1::GetServerInfoResponse* response) const;
  // Logs and counts a call that was not let in. Returns what its caller gets.
  grpc::Status Refuse(const grpc::CallbackServerContext& call, const absl::Status& status);

  ServiceContext& context_;
};

}  // namespace curvd
