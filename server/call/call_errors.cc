#include "server/call/call_errors.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "server/call/error_detail.h"
#include "server/call/reasons.h"

namespace curvd {

absl::Status ExplainJobError(absl::Status status) {
  switch (KindOf(status)) {
    case ErrorKind::kOutOfMemory:
      return ExplainOutOfMemory(std::move(status));
    case ErrorKind::kNeighborhoodTooLarge:
      return WithDetail(std::move(status), {kReasonNeighborhoodTooLarge, "header.options.radius", "", "", {}});
    case ErrorKind::kInvalid:
      return WithDetail(std::move(status), {kReasonInvalidOption, "header.options", "", "", {}});
    case ErrorKind::kCancelled:
    case ErrorKind::kOther:
      break;
  }
  return WithDetail(absl::InternalError(absl::StrCat("the estimate failed: ", status.ToString())),
                    {kReasonInternal, "", "", "", {}});
}

absl::Status ExplainCloudError(absl::Status status) {
  switch (KindOf(status)) {
    case ErrorKind::kOutOfMemory:
      return ExplainOutOfMemory(std::move(status));
    case ErrorKind::kInvalid:
      return WithDetail(std::move(status), {kReasonInvalidPoint, "chunk", "", "", {}});
    case ErrorKind::kNeighborhoodTooLarge:
    case ErrorKind::kCancelled:
    case ErrorKind::kOther:
      break;
  }
  return WithDetail(absl::InternalError(absl::StrCat("the cloud failed: ", status.ToString())),
                    {kReasonInternal, "", "", "", {}});
}

absl::Status ExplainOutOfMemory(absl::Status status) {
  return WithDetail(std::move(status), {kReasonOutOfMemory, "memory", "", "", absl::Seconds(1)});
}

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
  return MakeError(absl::StatusCode::kDeadlineExceeded,
                   {kReasonStalled,
                    for_room_to_send ? "time without room to send results" : "time without a message",
                    absl::StrCat("over ", seconds),
                    absl::StrCat("at most ", seconds, " (stall_timeout)"),
                    {}});
}

absl::Status DrainTimedOut(absl::Duration timeout) {
  const std::string seconds = absl::FormatDuration(timeout);
  return WithDetail(absl::UnavailableError(absl::StrCat("the server is draining and the call did not finish within ",
                                                        seconds, " (drain_timeout); send it to another replica")),
                    {kReasonDrainTimeout, "drain", "", seconds, {}});
}

}  // namespace curvd
