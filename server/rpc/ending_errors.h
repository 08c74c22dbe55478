// Makes the errors that may end any RPC, whatever it does.
#pragma once

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace curvd {

// The caller went away: DEADLINE_EXCEEDED if its deadline has passed, else CANCELLED.
absl::Status CallerGone(bool deadline_has_passed);

// The caller kept the server waiting for longer than `limit`, with its next message or with room to send.
absl::Status CallerStalls(bool for_room_to_send, absl::Duration limit);

// The server stops before the call could finish.
absl::Status DrainTimedOut(absl::Duration timeout);

}  // namespace curvd
