#include "client/token_interceptor.h"

#include <map>
#include <utility>

namespace curv {
namespace {

using grpc::experimental::InterceptionHookPoints;

class TokenInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit TokenInterceptor(std::shared_ptr<const std::string> authorization)
      : authorization_(std::move(authorization)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->emplace("authorization", *authorization_);
    }
    methods->Proceed();
  }

 private:
  const std::shared_ptr<const std::string> authorization_;
};

}  // namespace

TokenInterceptorFactory::TokenInterceptorFactory(const std::string& token)
    : authorization_(std::make_shared<const std::string>("Bearer " + token)) {}

grpc::experimental::Interceptor* TokenInterceptorFactory::CreateClientInterceptor(grpc::experimental::ClientRpcInfo*) {
  return new TokenInterceptor(authorization_);  // gRPC takes it
}

}  // namespace curv
