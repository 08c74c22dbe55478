#include "server/call/phase_clock.h"

namespace curvd {
namespace {

double Seconds(PhaseClock::Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

void PhaseClock::EndReceiving(Clock::time_point now) {
  if (receiving_since_.has_value()) times_.receive = Seconds(now - *receiving_since_) - times_.admit.value_or(0.0);
  receiving_since_.reset();
}

void PhaseClock::EndWaiting(Clock::time_point now) {
  if (waiting_since_.has_value()) times_.admit = times_.admit.value_or(0.0) + Seconds(now - *waiting_since_);
  waiting_since_.reset();
}

void PhaseClock::SetJobSeconds(const JobSeconds& seconds) {
  times_.queue = seconds.queue;
  times_.index = seconds.index;
  times_.normals = seconds.normals;
  times_.orientation = seconds.orientation;
  times_.estimate = seconds.estimate;
}

void PhaseClock::EndSending(Clock::time_point now) {
  if (sending_since_.has_value()) times_.send = Seconds(now - *sending_since_);
  sending_since_.reset();
}

void PhaseClock::End(Clock::time_point now) {
  EndWaiting(now);
  // A call that was refused before it got any memory has received nothing.
  if (times_.admit.has_value()) EndReceiving(now);
  EndSending(now);
}

}  // namespace curvd
