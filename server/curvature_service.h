// The RPCs of curvature.v1.CurvatureService.
#pragma once

#include "curvature/v1/curvature.grpc.pb.h"
#include "server/service_context.h"

namespace curvd {

// Thread-safe.
class CurvatureService final : public curvature::v1::CurvatureService::CallbackService {
 public:
  // `context` must outlive the service and its calls.
  explicit CurvatureService(ServiceContext& context) : context_(context) {}

  grpc::ServerBidiReactor<curvature::v1::EstimateCurvatureRequest, curvature::v1::EstimateCurvatureResponse>*
  EstimateCurvature(grpc::CallbackServerContext* call) override;

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* call,
                                          const curvature::v1::GetServerInfoRequest* request,
                                          curvature::v1::GetServerInfoResponse* response) override;

 private:
  ServiceContext& context_;
};

}  // namespace curvd
