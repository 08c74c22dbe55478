// Measures how long a call spends in each of its phases.
#pragma once

#include <chrono>
#include <optional>

#include "core/job/estimation_job.h"
#include "server/rpc/call_record.h"

namespace curvd {

// Told when each phase begins and ends, with moments that never decrease, it makes the PhaseTimes of the call's record.
// Not thread-safe.
class PhaseClock {
 public:
  using Clock = std::chrono::steady_clock;

  // The header is right, and chunks may come. They are received until EndReceiving, without the waits for memory.
  void StartReceiving(Clock::time_point now) { receiving_since_ = now; }
  void EndReceiving(Clock::time_point now);
  // The call asks for memory. It waits until EndWaiting, which has no effect if it does not wait.
  void StartWaiting(Clock::time_point now) { waiting_since_ = now; }
  void EndWaiting(Clock::time_point now);
  // The call was refused at once: it has not waited.
  void ForgetWaiting() { waiting_since_.reset(); }
  // What the job spent, so far or in all; nothing on a phase that it has not come to.
  void SetJobSeconds(const JobSeconds& seconds);
  void StartSending(Clock::time_point now) { sending_since_ = now; }
  void EndSending(Clock::time_point now);

  // The call is over: ends the phase that it is in.
  void End(Clock::time_point now);

  const PhaseTimes& times() const { return times_; }

 private:
  PhaseTimes times_;
  std::optional<Clock::time_point> receiving_since_;
  std::optional<Clock::time_point> waiting_since_;
  std::optional<Clock::time_point> sending_since_;
};

}  // namespace curvd
