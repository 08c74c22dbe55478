// Notes the calls that everybody may make, which access control never sees.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>

#include "server/net/connection_registry.h"

namespace curvd {

// For ServerBuilder: tells `connections` of each call to a service other than `own_service`, such as gRPC's own health
// service and reflection. Intercepts nothing. `connections` must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> NoteCallsBeside(const char* own_service,
                                                                                       ConnectionRegistry& connections);

}  // namespace curvd
