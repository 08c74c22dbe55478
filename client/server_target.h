// Reads where a server is, as --server and Connect take it.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace curv {

// What gRPC connects to for `server`, without the blanks around it: a host, an address of IPv6 or a name for dns: that
// has no port gets the default one, 50061; all else stays as it is. Errors: INVALID_ARGUMENT, it has neither host and
// port nor a scheme and what follows it ("localhost:50061", "unix:/run/curvd"), or its port is no number from 1 to
// 65535: gRPC would call port 99999 34463.
absl::StatusOr<std::string> ReadServerTarget(absl::string_view server);

}  // namespace curv
