// Memory pages for arrays of points and large buffers, and what the process keeps of them when those die.
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// Hands out ranges of pages of the system. Those that come back it returns to the system at once, unless it was told to
// keep some: fresh pages are cleared by the system, which is 3 to 6 % of the time of an estimate with 50 neighbors.
//
// What is handed out again takes memory whether it is written or not: arrays of which little may be written take fresh
// pages.
//
// Thread-safe.
class PagePool {
 public:
  using Clock = std::chrono::steady_clock;

  // Bytes of address space that must be left beside pages that come from the system: where it limits a process's
  // address space (ulimit -v), arrays never take the last of it. An array that cannot be had fails its call, but
  // libraries end the process when they get nothing. Other limits, such as that of a container, the system enforces
  // when pages are written, and no request for pages sees them.
  static constexpr size_t kLeftToOthers = size_t{32} << 20;

  PagePool() = default;
  ~PagePool();
  PagePool(const PagePool&) = delete;
  PagePool& operator=(const PagePool&) = delete;

  // Returns pages for `bytes` bytes, and up to a 32nd or a page more, with any content: kept ones of that size, else
  // pages of the system. Returns nullptr if there are none of either: the system has less than that and kLeftToOthers,
  // also after it got back all that is kept. REQUIRES: bytes > 0.
  void* Map(size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);

  // Takes back what Map(bytes) returned.
  void Unmap(void* pages, size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);

  // The same for arrays of which little may be written: pages that nobody had, which are zero and take memory as they
  // are written, and which go back to the system.
  void* MapFresh(size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);
  void UnmapFresh(void* pages, size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns whether the system has so much and kLeftToOthers now, if need be after it got back all that is kept; takes
  // nothing of it. For those who are about to let a library allocate as much. Takes a few microseconds. REQUIRES: bytes
  // > 0.
  bool HasRoomFor(size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);

  struct Limits {
    size_t kept = 0;      // bytes that are kept at most
    size_t together = 0;  // bytes in use and kept, unless those in use alone are more
  };
  // DEFAULT: keeps nothing.
  void SetLimits(const Limits& limits) ABSL_LOCKS_EXCLUDED(mutex_);

  // Gives back the kept pages that were not in use since `time`.
  void Release(Clock::time_point time) ABSL_LOCKS_EXCLUDED(mutex_);

  size_t kept_bytes() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Range {
    void* pages;
    size_t bytes;
    Clock::time_point unused_since;
  };

  // From the system, if need be after it got back all that is kept.
  void* MapNew(size_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);
  // The range of exactly so many bytes that came back last; nullptr if there is none.
  void* TakeKept(size_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReturnOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReturnSurplus() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  // In the order in which they came back. Its room is made beforehand: nothing is allocated when an array dies.
  std::vector<Range> kept_ ABSL_GUARDED_BY(mutex_);
  size_t kept_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t used_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  Limits limits_ ABSL_GUARDED_BY(mutex_);
};

// The pages of every PageArray of this process, and of every large ScratchArray (core/base/scratch_array.h).
PagePool& ProcessPages();

}  // namespace curvd
