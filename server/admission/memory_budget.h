// A number of bytes that calls share. Callers take turns.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/admission/waiting_claim.h"

namespace curvd {

// What is free goes to whoever's turn it is. While somebody waits:
// - Calls that hold bytes already and need more go before those that hold none. If every holder waits for more, nobody
//   could ever go on, so one of them is refused: the youngest that waits, of the caller that holds the most.
// - The next turn is that of the caller that has had the least, in bytes times seconds, since somebody began to wait; a
//   caller that comes later begins with as much as the one had who was served last. The calls of one caller are served
//   in the order in which they came.
// - A call that does not fit lets calls of other callers pass that do, within the bounds that WaitingClaim sets: nobody
//   starves, and nobody who waits holds up others for more than half of the time. A call that could not be served
//   even if all other callers left, since its own caller holds too much, holds up nobody else.
// - When too many wait, a place goes from the caller that has the most places to one that has fewer.
// Thread-safe.
class MemoryBudget {
 public:
  class Reservation;
  using Clock = std::chrono::steady_clock;

  // At most `max_waiting` reservations that hold nothing may wait at a time. `now` tells the time, which must not go
  // back. `limit_name` says in errors what the limit is of what the operator has set.
  MemoryBudget(uint64_t limit_bytes, size_t max_waiting, std::function<Clock::time_point()> now = Clock::now,
               std::string limit_name = "memory_limit")
      : limit_(limit_bytes), limit_name_(std::move(limit_name)), max_waiting_(max_waiting), now_(std::move(now)) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  uint64_t limit() const { return limit_; }
  uint64_t reserved() const;
  // Reservations that wait.
  size_t waiting() const;

  // Serves those who may pass now that time has gone by. To be called now and then, while somebody waits.
  void Tick();

 private:
  // What a caller has and waits for.
  struct Account {
    uint64_t held = 0;
    double used = 0.0;        // byte seconds, up to `since`
    Clock::time_point since;  // only while somebody waits
    size_t reservations = 0;  // that hold bytes or wait
    std::list<Reservation*> newcomers;
  };
  struct Answer {
    std::function<void(absl::Status)> callback;
    absl::Status status;
  };
  using Answers = std::vector<Answer>;

  bool AnyWaits() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !growers_.empty() || newcomers_ > 0; }
  bool Fits(const Reservation& reservation) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Account& Join(uint64_t caller, Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Settle(Account& account, Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SettleAll(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Leave(uint64_t caller) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void Enqueue(Reservation& reservation, Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Dequeue(Reservation& reservation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Grant(Reservation& reservation, Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Refuse(Reservation& reservation, absl::Status status, Answers& answers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // Whether the first has the earlier turn.
  bool IsBefore(const Reservation& a, const Reservation& b) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Whether it could be served if all other callers left.
  bool CanBeServed(const Reservation& reservation) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool ServeGrower(Clock::time_point now, Answers& answers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool ServeNewcomer(Clock::time_point now, Answers& answers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RefuseOneOfAllHolders(Answers& answers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RefuseOneOfTooMany(Answers& answers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The first reservations of those callers that wait and hold nothing, in the order of their turns.
  std::vector<Reservation*> Heads() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Serves what can be served at `now`; the answers are to be given without the lock.
  Answers Serve(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static void Give(Answers answers);

  const uint64_t limit_;
  const std::string limit_name_;
  const size_t max_waiting_;
  const std::function<Clock::time_point()> now_;
  mutable Mutex mutex_;
  uint64_t reserved_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t active_holders_ ABSL_GUARDED_BY(mutex_) = 0;  // hold bytes and do not wait
  uint64_t arrivals_ ABSL_GUARDED_BY(mutex_) = 0;
  double level_ ABSL_GUARDED_BY(mutex_) = 0.0;  // byte seconds that the caller had who was served last
  std::unordered_map<uint64_t, Account> accounts_ ABSL_GUARDED_BY(mutex_);
  std::list<Reservation*> growers_ ABSL_GUARDED_BY(mutex_);
  size_t newcomers_ ABSL_GUARDED_BY(mutex_) = 0;
};

// One call's share; given back on destruction. Thread-safe, save that GrowTo must not run twice at a time.
class MemoryBudget::Reservation {
 public:
  // `caller` stands for the one whose call it is, and with whose other calls it shares its turns.
  explicit Reservation(MemoryBudget& budget, uint64_t caller = 0) : budget_(budget), caller_(caller) {}
  ~Reservation();
  Reservation(const Reservation&) = delete;
  Reservation& operator=(const Reservation&) = delete;

  // Makes the share at least `bytes`. Returns true if it is so now; false if the call has to wait: `answer` is then
  // called once, with OK when the share was granted or with an error as below, on the thread that made it possible,
  // unless Abandon comes first. Errors, all RESOURCE_EXHAUSTED:
  // - MEMORY_LIMIT: more than the whole budget.
  // - QUEUE_FULL, with a time to wait: too many wait already; also as an answer, if others came who had fewer places.
  // - MEMORY_BUSY, with a time to wait: all holders wait for more.
  // And CANCELLED after Abandon.
  //
  // `needed_now`, at most `bytes`, is what the call needs for now; what it has beyond that may be lent (see Lend). Once
  // it was, the share grows no further than it is needed.
  // DEFAULT of needed_now: bytes.
  absl::StatusOr<bool> GrowTo(uint64_t bytes, std::function<void(absl::Status)> answer) {
    return GrowTo(bytes, bytes, std::move(answer));
  }
  absl::StatusOr<bool> GrowTo(uint64_t bytes, uint64_t needed_now, std::function<void(absl::Status)> answer);
  // Gives back what is not needed now, if others wait for memory and this call does not. From then on the call has to
  // wait for its turn whenever it needs more, as one does whose size nobody knows.
  void Lend();
  // Gives back what is above `bytes`.
  void ShrinkTo(uint64_t bytes);
  // The call has ended: stops waiting, and never waits again, for the end may come right before GrowTo. An answer that
  // is being given on another thread may still arrive.
  void Abandon();
  // Whether any call waits for memory of this budget, so that what this one does not need is missed.
  bool IsMissed() const { return budget_.waiting() > 0; }

 private:
  friend class MemoryBudget;

  // Shrinks to `bytes` and returns the answers to be given. REQUIRES: the budget's mutex is held, bytes < held_.
  Answers Shrink(uint64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(budget_.mutex_);

  // Guarded by the budget's mutex.
  MemoryBudget& budget_;
  const uint64_t caller_;
  uint64_t held_ = 0;
  uint64_t wanted_ = 0;
  uint64_t needed_ = 0;
  bool has_lent_ = false;
  uint64_t arrival_ = 0;
  bool abandoned_ = false;
  bool waits_ = false;
  std::optional<WaitingClaim> claim_;  // while it waits and holds nothing
  absl::Status refusal_;
  std::function<void(absl::Status)> answer_;  // set while it waits, once GrowTo has returned
};

}  // namespace curvd
