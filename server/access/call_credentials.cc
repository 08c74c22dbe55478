#include "server/access/call_credentials.h"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/auth_context.h>
#include <grpcpp/server_context.h>

namespace curvd {

PresentedCredentials CredentialsOf(const grpc::ServerContextBase& call) {
  PresentedCredentials presented;
  presented.peer = call.peer();
  const auto authorization = call.client_metadata().find("authorization");
  if (authorization != call.client_metadata().end()) {
    presented.authorization.emplace(authorization->second.data(), authorization->second.size());
  }
  const std::shared_ptr<const grpc::AuthContext> context = call.auth_context();
  if (context == nullptr || !context->IsPeerAuthenticated()) return presented;
  for (const char* property : {GRPC_X509_CN_PROPERTY_NAME, GRPC_X509_SAN_PROPERTY_NAME}) {
    for (const grpc::string_ref& name : context->FindPropertyValues(property)) {
      presented.certificate_names.emplace_back(name.data(), name.size());
    }
  }
  return presented;
}

}  // namespace curvd
