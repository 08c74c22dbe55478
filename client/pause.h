// Waiting that can be cut short.
#pragma once

#include <stop_token>

#include "absl/time/time.h"

namespace curv {

// Waits for `duration`; returns false as soon as `stop` is requested.
bool PauseFor(absl::Duration duration, const std::stop_token& stop);

}  // namespace curv
