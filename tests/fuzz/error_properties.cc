#include "tests/fuzz/error_properties.h"

#include <algorithm>
#include <string>

#include "client/curvature_client.h"
#include "client/rpc_error.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"
#include "server/rpc/grpc_status.h"
#include "tests/fuzz/require.h"

namespace fuzz {

void CheckRequestError(const absl::Status& status) {
  Require(absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status),
          "a bad request is INVALID_ARGUMENT or RESOURCE_EXHAUSTED");
  const std::string reason = curvd::ReasonOf(status);
  Require(std::any_of(std::begin(curvd::kAllReasons), std::end(curvd::kAllReasons),
                      [&](const char* known) { return reason == known; }),
          "the reason is a known one");

  const absl::Status arrived = curv::ToAbslStatus(curvd::ToGrpcStatus(status, "0badcafe-7"));
  Require(arrived.code() == status.code(), "the code reaches the client");
  Require(curv::ErrorReason(arrived) == reason, "the reason reaches the client");
  const std::string message(arrived.message());
  Require(IsShowable(message), "messages are printable");
  Require(message.find(std::string(status.message())) != std::string::npos, "the message reaches the client");
  Require(message.find("0badcafe-7") != std::string::npos, "the request id reaches the client");
}

}  // namespace fuzz
