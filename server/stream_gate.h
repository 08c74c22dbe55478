// Which calls are open, whether further ones may come, and when the last one has gone.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/mutex.h"

namespace curvd {

// A call as the gate sees it. Thread-safe.
class OpenStream {
 public:
  virtual ~OpenStream() = default;
  // A chance to show progress and to notice a peer that does not move.
  virtual void Tick(std::chrono::steady_clock::time_point now) = 0;
  // Ends the call with `status`, unless it has ended.
  virtual void Abort(absl::Status status) = 0;
};

// Thread-safe.
class StreamGate {
 public:
  explicit StreamGate(size_t max_streams) : max_streams_(max_streams) {}

  // Lets a call in until Close. Errors:
  // - UNAVAILABLE, DRAINING: the server is about to stop.
  // - RESOURCE_EXHAUSTED, STREAM_LIMIT: max_streams calls are open.
  absl::Status Open(const std::shared_ptr<OpenStream>& stream);
  // No effect if the stream was never let in.
  void Close(const OpenStream* stream);

  void StartDraining();
  bool draining() const;
  // Returns whether all calls have closed before `timeout`.
  bool WaitUntilEmpty(absl::Duration timeout);

  size_t open_count() const;
  std::vector<std::shared_ptr<OpenStream>> open_streams() const;

 private:
  const size_t max_streams_;
  mutable Mutex mutex_;
  CondVar emptied_;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::unordered_map<const OpenStream*, std::weak_ptr<OpenStream>> streams_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
