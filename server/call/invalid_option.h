// The errors of options that are out of their range.
#pragma once

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

// INVALID_ARGUMENT with the message "FIELD is VALUE; it must be LIMIT".
inline absl::Status InvalidOption(std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, std::move(field), std::move(value), std::move(limit), {}});
}

// The same for an error of the core, whose field lies at `path` in the request: "header.options.". REQUIRES: it is of
// kind kInvalid, and made with a subject.
inline absl::Status InvalidOptionAt(const char* path, const absl::Status& error) {
  ErrorSubject subject = SubjectOf(error);
  return InvalidOption(absl::StrCat(path, subject.field), std::move(subject.value), std::move(subject.limit));
}

}  // namespace curvd
