// A number of bytes that calls share, first come, first served.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"

namespace curvd {

// Nobody overtakes: a request that could be served waits behind one that came earlier and could not. Calls that hold
// bytes already and need more go before those that hold none; if every holder waits for more, nobody could ever go on,
// so the youngest of them is refused. Thread-safe.
class MemoryBudget {
 public:
  class Reservation;

  // At most `max_waiting` reservations that hold nothing may wait at a time.
  MemoryBudget(uint64_t limit_bytes, size_t max_waiting) : limit_(limit_bytes), max_waiting_(max_waiting) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  uint64_t limit() const { return limit_; }
  uint64_t reserved() const;
  // Reservations that wait.
  size_t waiting() const;

 private:
  struct Answer {
    std::function<void(absl::Status)> callback;
    absl::Status status;
  };
  using Answers = std::vector<Answer>;

  bool Fits(uint64_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return reserved_ + bytes <= limit_; }
  bool CanServe(const Reservation& reservation) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Grant(Reservation& reservation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Enqueue(Reservation& reservation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Serves what can be served now; the answers are to be given without the lock.
  Answers Serve() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool Forget(Reservation& reservation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static void Give(Answers answers);

  const uint64_t limit_;
  const size_t max_waiting_;
  mutable Mutex mutex_;
  uint64_t reserved_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t active_holders_ ABSL_GUARDED_BY(mutex_) = 0;  // hold bytes and do not wait
  std::deque<Reservation*> growers_ ABSL_GUARDED_BY(mutex_);
  std::deque<Reservation*> newcomers_ ABSL_GUARDED_BY(mutex_);
};

// One call's share; given back on destruction. Thread-safe, save that GrowTo must not run twice at a time.
class MemoryBudget::Reservation {
 public:
  explicit Reservation(MemoryBudget& budget) : budget_(budget) {}
  ~Reservation();
  Reservation(const Reservation&) = delete;
  Reservation& operator=(const Reservation&) = delete;

  // Makes the share at least `bytes`. Returns true if it is so now; false if the call has to wait: `answer` is then
  // called once, with OK when the share was granted or with an error as below, on the thread that made it possible,
  // unless Abandon comes first. Errors, all RESOURCE_EXHAUSTED:
  // - MEMORY_LIMIT: more than the whole budget.
  // - QUEUE_FULL, with a time to wait: too many wait already.
  // - MEMORY_BUSY, with a time to wait: all holders wait for more.
  // And CANCELLED after Abandon.
  absl::StatusOr<bool> GrowTo(uint64_t bytes, std::function<void(absl::Status)> answer);
  // Gives back what is above `bytes`.
  void ShrinkTo(uint64_t bytes);
  // The call has ended: stops waiting, and never waits again, for the end may come right before GrowTo. An answer that
  // is being given on another thread may still arrive.
  void Abandon();

 private:
  friend class MemoryBudget;

  // Guarded by the budget's mutex.
  MemoryBudget& budget_;
  uint64_t held_ = 0;
  uint64_t wanted_ = 0;
  bool abandoned_ = false;
  std::function<void(absl::Status)> answer_;  // set while it waits
};

}  // namespace curvd
