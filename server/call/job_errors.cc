#include "server/call/job_errors.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

// The error with the reason that callers see, and with what the core says about the field, which the request has at
// `field`.
absl::Status Explain(absl::Status error, const char* reason, std::string field) {
  ErrorSubject subject = SubjectOf(error);
  const std::string point = std::move(subject.point);
  error =
      WithDetail(std::move(error), {reason, std::move(field), std::move(subject.value), std::move(subject.limit), {}});
  return point.empty() ? error : WithMetadata(std::move(error), "point", point);
}

}  // namespace

absl::Status ExplainJobError(absl::Status status, const char* radius_field) {
  switch (KindOf(status)) {
    case ErrorKind::kOutOfMemory:
      return ExplainOutOfMemory(std::move(status));
    case ErrorKind::kNeighborhoodTooLarge:
      return Explain(std::move(status), kReasonNeighborhoodTooLarge, radius_field);
    case ErrorKind::kOpposedNormals:
      return Explain(std::move(status), kReasonOpposedNormals, "chunk.normals");
    case ErrorKind::kRepeatedId:
      return Explain(std::move(status), kReasonInvalidPoint, "chunk.ids");
    case ErrorKind::kInvalid:
      return Explain(std::move(status), kReasonInvalidOption, "header.options");
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
    case ErrorKind::kInvalid: {
      const std::string array = SubjectOf(status).field;
      return Explain(std::move(status), kReasonInvalidPoint, array.empty() ? "chunk" : absl::StrCat("chunk.", array));
    }
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
