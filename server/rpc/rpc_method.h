// Lists the RPCs of curvature.v1.CurvatureService, as metrics and the log name them.
#pragma once

#include <array>
#include <cstddef>

namespace curvd {

enum class RpcMethod { kEstimateCurvature, kGetServerInfo };

struct RpcMethodNames {
  const char* type;  // as other gRPC servers name it in the label grpc_type: "unary", "bidi_stream", ...
  const char* name;  // as in the contract
};

// One row for each RpcMethod, in its order.
inline constexpr std::array<RpcMethodNames, 2> kRpcMethods = {{
    {"bidi_stream", "EstimateCurvature"},
    {"unary", "GetServerInfo"},
}};

inline const RpcMethodNames& NamesOf(RpcMethod method) { return kRpcMethods[static_cast<size_t>(method)]; }

}  // namespace curvd
