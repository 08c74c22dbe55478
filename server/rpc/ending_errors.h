// Makes the errors that may end any RPC, whatever it does.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace curvd {

// The caller went away: DEADLINE_EXCEEDED if its deadline has passed, else CANCELLED.
absl::Status CallerGone(bool deadline_has_passed);

// The caller kept the server waiting for longer than `limit`, with a message that brings anything or with room to send.
absl::Status CallerStalls(bool for_room_to_send, absl::Duration limit);

// While others waited for memory, the caller sent, or took, fewer than `bytes_per_second` for longer than `limit`.
absl::Status CallerIsSlow(bool for_room_to_send, int64_t bytes_per_second, absl::Duration limit);

// The server stops before the call could finish.
absl::Status DrainTimedOut(absl::Duration timeout);

}  // namespace curvd
