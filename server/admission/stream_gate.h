// Which calls are open and whose they are, whether further ones may come, and when the last one has gone.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/access/caller.h"

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
  // While several callers have calls open, each may have so many for each place that is free. So callers who take what
  // they can get share alike, and leave places for those who come.
  static constexpr size_t kCallsPerFreePlace = 8;

  // At most `max_streams` calls are open, at most `max_streams_per_peer` of them under one caller's name.
  StreamGate(size_t max_streams, size_t max_streams_per_peer)
      : max_streams_(max_streams), max_streams_per_peer_(max_streams_per_peer) {}

  // Lets a call in until Close. Errors:
  // - UNAVAILABLE, DRAINING: the server is about to stop.
  // - RESOURCE_EXHAUSTED, STREAM_LIMIT: max_streams calls are open.
  // - RESOURCE_EXHAUSTED, PEER_STREAM_LIMIT: the caller has as many open as it, or any peer, may; or as many as are
  //   left to it while others have calls open.
  absl::Status Open(const std::shared_ptr<OpenStream>& stream, const Caller& caller);
  // Its caller is about to learn how the call ended, and may open another in its place. No effect if the stream was
  // never let in.
  void FreePlace(const OpenStream* stream);
  // The call is over. No effect if the stream was never let in.
  void Close(const OpenStream* stream);

  // Ends every open call for whose caller `verdict` is not OK, with that status.
  void EndWhere(const std::function<absl::Status(const Caller&)>& verdict);

  void StartDraining();
  bool draining() const;
  // Returns whether all calls have closed before `timeout`.
  bool WaitUntilEmpty(absl::Duration timeout);

  size_t open_count() const;
  std::vector<std::shared_ptr<OpenStream>> open_streams() const;

 private:
  struct Entry {
    std::weak_ptr<OpenStream> stream;
    Caller caller;
    bool holds_place = true;  // in open_by_name_
  };
  void FreePlace(Entry& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t max_streams_;
  const size_t max_streams_per_peer_;
  mutable Mutex mutex_;
  CondVar emptied_;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::unordered_map<const OpenStream*, Entry> streams_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, size_t> open_by_name_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
