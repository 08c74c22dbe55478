// Bounds how many lines of one kind the log gets.
#pragma once

#include <chrono>
#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// Lets a few lines a second through, so that strangers cannot drown the log, and counts the others. Thread-safe.
class LogRateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr int kLinesPerSecond = 20;

  // Whether a line may be written at `now`. If so, `left_out` becomes the number of lines that were not since the last
  // that was. REQUIRES: `now` does not go back.
  bool MayWrite(Clock::time_point now, uint64_t& left_out);

 private:
  Mutex mutex_;
  Clock::time_point second_ ABSL_GUARDED_BY(mutex_);  // when the second that counts began
  int lines_ ABSL_GUARDED_BY(mutex_) = 0;             // in that second
  uint64_t left_out_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace curvd
