#include "server/net/open_calls.h"

#include <grpcpp/server_context.h>

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

// Whether `status` answers a call, and does not only say that its peer has gone, or sent no message with it.
bool IsAnswer(const grpc::Status& status) { return status.ok() || status.error_code() == grpc::StatusCode::NOT_FOUND; }

// Lives as long as the call.
class OpenCall final : public grpc::experimental::Interceptor {
 public:
  OpenCall(const grpc::ServerContextBase& call, ConnectionRegistry& connections)
      : peer_(call.peer()), metadata_bytes_(MetadataBytes(call)), connections_(connections) {
    connections_.NoteCall(peer_, ConnectionRegistry::Call::kOpenToAll, metadata_bytes_);
  }
  ~OpenCall() override {
    connections_.NoteOpenToAllEnd(peer_);
    if (is_answered_) connections_.NoteAnswered(peer_, metadata_bytes_);
  }

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(grpc::experimental::InterceptionHookPoints::PRE_SEND_STATUS)) {
      is_answered_ = IsAnswer(methods->GetSendStatus());
    }
    methods->Proceed();
  }

 private:
  const std::string peer_;
  const uint64_t metadata_bytes_;
  ConnectionRegistry& connections_;
  bool is_answered_ = false;
};

class OpenCallNoter final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  OpenCallNoter(std::string own_prefix, ConnectionRegistry& connections)
      : own_prefix_(std::move(own_prefix)), connections_(connections) {}

  // Null: the call goes on without an interceptor.
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* call) override {
    if (absl::StartsWith(call->method(), own_prefix_)) return nullptr;
    return new OpenCall(*call->server_context(), connections_);
  }

 private:
  const std::string own_prefix_;
  ConnectionRegistry& connections_;
};

}  // namespace

uint64_t MetadataBytes(const grpc::ServerContextBase& call) {
  constexpr uint64_t kEntryBytes = 32;
  uint64_t bytes = 0;
  for (const auto& [name, value] : call.client_metadata()) bytes += name.size() + value.size() + kEntryBytes;
  return bytes;
}

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> NoteCallsBeside(
    const char* own_service, ConnectionRegistry& connections) {
  return std::make_unique<OpenCallNoter>(absl::StrCat("/", own_service, "/"), connections);
}

}  // namespace curvd
