// The error of a point that is refused.
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/status.h"

namespace curvd {

// Returns kInvalid (core/base/error.h) for the point at place `point` of the input, with the message "WHAT of point
// POINT is VALUE; it must be LIMIT" and `remedy`, beside which the point may also be skipped. `what` is "position",
// "normal" or "viewpoint"; the subject's field is the array of these, as "positions".
absl::Status InvalidPoint(const char* what, size_t point, std::string value, std::string limit,
                          const char* remedy = "mend the point");

}  // namespace curvd
