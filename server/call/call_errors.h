// The errors that end a call beside those of its request.
#pragma once

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace curvd {

// Returns an error of an EstimationJob with the reason that callers see, by its kind (core/base/error.h); one of an
// unexpected kind is INTERNAL. REQUIRES: !status.ok().
absl::Status ExplainJobError(absl::Status status);

// The same for an error of a Cloud that takes points, whose messages already name point and value.
// REQUIRES: !status.ok().
absl::Status ExplainCloudError(absl::Status status);

// The same for an error of kind kOutOfMemory, wherever it comes from.
absl::Status ExplainOutOfMemory(absl::Status status);

// The caller went away: DEADLINE_EXCEEDED if its deadline has passed, else CANCELLED.
absl::Status CallerGone(bool deadline_has_passed);

// The caller kept the server waiting for longer than `limit`, with its next message or with room to send.
absl::Status CallerStalls(bool for_room_to_send, absl::Duration limit);

// The server stops before the call could finish.
absl::Status DrainTimedOut(absl::Duration timeout);

}  // namespace curvd
