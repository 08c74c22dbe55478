// Notes the calls that everybody may make, which access control never sees.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <cstdint>
#include <memory>

#include "server/net/connection_registry.h"

namespace grpc {
class ServerContextBase;
}  // namespace grpc

namespace curvd {

// Bytes of the metadata of `call` as HTTP/2 counts them: 32 beside each name and value.
uint64_t MetadataBytes(const grpc::ServerContextBase& call);

// For ServerBuilder: tells `connections` when a call to a service other than `own_service`, such as gRPC's own health
// service and reflection, arrives and ends. Changes nothing about it. `connections` must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> NoteCallsBeside(const char* own_service,
                                                                                       ConnectionRegistry& connections);

}  // namespace curvd
