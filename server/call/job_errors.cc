#include "server/call/job_errors.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

absl::Status ExplainJobError(absl::Status status) {
  if (absl::IsResourceExhausted(status)) {
    if (absl::StartsWith(status.message(), "out of memory")) {
      return WithDetail(std::move(status), {kReasonOutOfMemory, "memory", "", "", absl::Seconds(1)});
    }
    return WithDetail(std::move(status), {kReasonNeighborhoodTooLarge, "header.options.radius", "", "", {}});
  }
  if (absl::IsInvalidArgument(status)) {
    return WithDetail(std::move(status), {kReasonInvalidOption, "header.options", "", "", {}});
  }
  return WithDetail(absl::InternalError(absl::StrCat("the estimate failed: ", status.ToString())),
                    {kReasonInternal, "", "", "", {}});
}

}  // namespace curvd
