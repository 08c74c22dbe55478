// Counts and logs those who never came to make a call.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/observe/security_metrics.h"
#include "server/observe/server_log.h"

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
  // A line that gRPC wrote itself: counted and logged if it tells of a stranger, else logged if `is_error`. The peer of
  // a handshake that failed is in the line where its connection broke; else it is whom FindPeersWith's function names.
  void NoteGrpcLine(const std::string& file, const std::string& message, bool is_error);
  // `peer_being_closed` names the peer of the one connection that is being closed now, or returns "". It is called on
  // any thread, maybe with locks of gRPC held, until it is replaced; null for none.
  void FindPeersWith(std::function<std::string()> peer_being_closed);

 private:
  // Counts the stranger; `find_peer` is called only if a line is written.
  void NoteAndFind(StrangerReason reason, const std::function<std::string()>& find_peer, const std::string& message);
  std::string PeerOfFailedHandshake(const std::string& message);
  // Whether a line may be written now; if so, `left_out` is how many were not since the last one.
  bool MayLog(uint64_t& left_out);

  SecurityMetrics& metrics_;
  ServerLog& log_;
  Mutex mutex_;
  Clock::time_point second_ ABSL_GUARDED_BY(mutex_);
  int lines_ ABSL_GUARDED_BY(mutex_) = 0;  // in that second
  uint64_t left_out_ ABSL_GUARDED_BY(mutex_) = 0;
  Mutex peer_mutex_;
  std::function<std::string()> peer_being_closed_ ABSL_GUARDED_BY(peer_mutex_);
};

}  // namespace curvd
