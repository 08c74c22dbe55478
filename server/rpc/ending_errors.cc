#include "server/rpc/ending_errors.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

absl::Status CallerGone(bool deadline_has_passed) {
  if (deadline_has_passed) {
    return WithDetail(absl::DeadlineExceededError("the caller's deadline has passed"),
                      {kReasonDeadlineExceeded, "deadline", "", "", {}});
  }
  return WithDetail(absl::CancelledError("the caller cancelled the call or went away"),
                    {kReasonCancelled, "", "", "", {}});
}

absl::Status CallerStalls(bool for_room_to_send, absl::Duration limit) {
  const std::string seconds = absl::FormatDuration(limit);
  return MakeError(
      absl::StatusCode::kDeadlineExceeded,
      {kReasonStalled,
       for_room_to_send ? "time without room to send results" : "time without a message that brings anything",
       absl::StrCat("over ", seconds),
       absl::StrCat("at most ", seconds, " (stall_timeout)"),
       {}});
}

absl::Status CallerIsSlow(bool for_room_to_send, int64_t bytes_per_second, absl::Duration limit) {
  return MakeError(absl::StatusCode::kDeadlineExceeded,
                   {kReasonStalled,
                    for_room_to_send ? "bytes of results taken per second" : "bytes of points sent per second",
                    absl::StrCat("too few for ", absl::FormatDuration(limit), " while others wait for memory"),
                    absl::StrCat("at least ", bytes_per_second, ", averaged over stall_timeout"),
                    {}});
}

absl::Status DrainTimedOut(absl::Duration timeout) {
  const std::string seconds = absl::FormatDuration(timeout);
  return WithDetail(absl::UnavailableError(absl::StrCat("the server is draining and the call did not finish within ",
                                                        seconds, " (drain_timeout); send it to another replica")),
                    {kReasonDrainTimeout, "drain", "", seconds, {}});
}

}  // namespace curvd
