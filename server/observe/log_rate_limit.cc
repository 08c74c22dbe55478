#include "server/observe/log_rate_limit.h"

#include <utility>

namespace curvd {

bool LogRateLimit::MayWrite(Clock::time_point now, uint64_t& left_out) {
  MutexLock lock(mutex_);
  if (now - second_ >= std::chrono::seconds(1)) {
    second_ = now;
    lines_ = 0;
  }
  if (lines_ == kLinesPerSecond) {
    ++left_out_;
    return false;
  }
  ++lines_;
  left_out = std::exchange(left_out_, 0);
  return true;
}

}  // namespace curvd
