// Reads where a server is, as --server and Connect take it.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace curv {

// What gRPC connects to for each part of `servers`, which have commas between, without the blanks around it: a host, an
// address of IPv6 or a name for dns: that has no port gets the default one, 50061; all else stays as it is. Errors:
// INVALID_ARGUMENT, a part has neither host and port nor a scheme and what follows it ("localhost:50061",
// "unix:/run/curvd"), is a URL of the web, or has a port that is no number from 1 to 65535: gRPC would call port 99999
// 34463.
absl::StatusOr<std::vector<std::string>> ReadServerTargets(absl::string_view servers);

}  // namespace curv
