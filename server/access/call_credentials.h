// Reads from gRPC what a call shows of who makes it.
#pragma once

#include "server/access/access_control.h"

namespace grpc {
class ServerContextBase;
}  // namespace grpc

namespace curvd {

PresentedCredentials CredentialsOf(const grpc::ServerContextBase& call);

}  // namespace curvd
