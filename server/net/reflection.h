// Leaves out gRPC's server reflection, which every server of a program has that is linked with it.
#pragma once

namespace grpc {
class ServerBuilder;
}  // namespace grpc

namespace curvd {

// Lets the server that `builder` makes do without reflection.
void LeaveOutReflection(grpc::ServerBuilder& builder);

}  // namespace curvd
