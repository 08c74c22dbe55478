// The error of an option that is out of its range.
#pragma once

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

// INVALID_ARGUMENT with the message "FIELD is VALUE; it must be LIMIT".
inline absl::Status InvalidOption(std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, std::move(field), std::move(value), std::move(limit), {}});
}

}  // namespace curvd
