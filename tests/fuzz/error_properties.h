// What every error that leaves the server must be.
#pragma once

#include "absl/status/status.h"

namespace fuzz {

// Requires of an error about a request: its code is INVALID_ARGUMENT or RESOURCE_EXHAUSTED, its reason is one that
// docs/protocol.md lists, its message is printable, and all of that, with the request id, reaches the C++ client.
void CheckRequestError(const absl::Status& status);

}  // namespace fuzz
