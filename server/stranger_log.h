// Counts and logs those who never came to make a call.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/base/thread_annotations.h"
#include "core/mutex.h"
#include "server/security_metrics.h"
#include "server/server_log.h"

namespace curvd {

// Counts every one, and logs at most 20 a second, so that strangers cannot drown the log; the next line tells how many
// were left out. Thread-safe.
class StrangerLog {
 public:
  using Clock = std::chrono::steady_clock;

  // Both must outlive this.
  StrangerLog(SecurityMetrics& metrics, ServerLog& log) : metrics_(metrics), log_(log) {}

  // `peer` may be empty where nobody knows.
  void Note(StrangerReason reason, const std::string& peer, const std::string& message);
  // A connection that was closed because of a limit.
  void NoteRefused(StrangerReason reason, const std::string& peer);
  // A line that gRPC wrote itself: counted and logged if it tells of a stranger, else logged if `is_error`.
  void NoteGrpcLine(const std::string& file, const std::string& message, bool is_error);

 private:
  // Whether a line may be written now; if so, `left_out` is how many were not since the last one.
  bool MayLog(uint64_t& left_out);

  SecurityMetrics& metrics_;
  ServerLog& log_;
  Mutex mutex_;
  Clock::time_point second_ ABSL_GUARDED_BY(mutex_);
  int lines_ ABSL_GUARDED_BY(mutex_) = 0;  // in that second
  uint64_t left_out_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace curvd
