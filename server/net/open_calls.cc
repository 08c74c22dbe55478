#include "server/net/open_calls.h"

#include <grpcpp/server_context.h>

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

class OpenCallNoter final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  OpenCallNoter(std::string own_prefix, ConnectionRegistry& connections)
      : own_prefix_(std::move(own_prefix)), connections_(connections) {}

  // Null: the call goes on without an interceptor.
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* call) override {
    if (!absl::StartsWith(call->method(), own_prefix_)) {
      connections_.NoteCall(call->server_context()->peer(), ConnectionRegistry::Call::kOpenToAll);
    }
    return nullptr;
  }

 private:
  const std::string own_prefix_;
  ConnectionRegistry& connections_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> NoteCallsBeside(
    const char* own_service, ConnectionRegistry& connections) {
  return std::make_unique<OpenCallNoter>(absl::StrCat("/", own_service, "/"), connections);
}

}  // namespace curvd
