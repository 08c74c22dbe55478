// absl::Status that carries the google.rpc details which curvd's callers get.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace curvd {

// ErrorInfo.domain of every error of ours.
inline constexpr char kErrorDomain[] = "curvd";

struct ErrorDetail {
  std::string reason;  // one of server/rpc/error_reasons.h
  std::string field;   // what is wrong, as a path in the request ("header.point_count") or the name of a limit
  std::string value;   // what it is
  std::string limit;   // what it must be, as a phrase after "must be": "at least 4"
  // How long to wait before the next try; ZeroDuration() where waiting does not help.
  absl::Duration retry_after = absl::ZeroDuration();
};

// An error with the message "FIELD is VALUE; it must be LIMIT" and the detail attached.
absl::Status MakeError(absl::StatusCode code, const ErrorDetail& detail);

// `status` with its own code and message, and the detail in place of what was attached before. REQUIRES: !status.ok().
absl::Status WithDetail(absl::Status status, const ErrorDetail& detail);

// The reason attached to `status`, or the name of its code if there is none.
std::string ReasonOf(const absl::Status& status);

// `status` with one more entry in ErrorInfo.metadata. REQUIRES: !status.ok().
absl::Status WithMetadata(absl::Status status, const std::string& key, const std::string& value);

}  // namespace curvd
