#include "server/call/job_errors.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

absl::Status ExplainJobError(absl::Status status, const char* radius_field) {
  switch (KindOf(status)) {
    case ErrorKind::kOutOfMemory:
      return ExplainOutOfMemory(std::move(status));
    case ErrorKind::kNeighborhoodTooLarge:
      return WithDetail(std::move(status), {kReasonNeighborhoodTooLarge, radius_field, "", "", {}});
    case ErrorKind::kOpposedNormals:
      return WithDetail(std::move(status), {kReasonOpposedNormals, "chunk.normals", "", "", {}});
    case ErrorKind::kRepeatedId:
      return WithDetail(std::move(status), {kReasonInvalidPoint, "chunk.ids", "", "", {}});
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
    case ErrorKind::kOpposedNormals:
    case ErrorKind::kRepeatedId:
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

}  // namespace curvd
