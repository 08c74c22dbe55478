#include "server/host/ticker.h"

#include <utility>

namespace curvd {

Ticker::Ticker(Clock::duration interval, std::function<void(Clock::time_point)> tick)
    : interval_(interval), tick_(std::move(tick)), thread_([this] { Run(); }) {}

Ticker::~Ticker() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    stopped_.NotifyAll();
  }
  thread_.join();
}

void Ticker::Run() {
  Clock::time_point next = Clock::now() + interval_;
  for (;;) {
    {
      MutexLock lock(mutex_);
      while (!stopping_ && stopped_.WaitUntil(mutex_, next)) {
      }
      if (stopping_) return;
    }
    next = Clock::now() + interval_;
    tick_(Clock::now());
  }
}

}  // namespace curvd
