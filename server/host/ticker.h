// Does something small again and again on a thread of its own.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// Calls `tick` with the time every `interval` until destroyed.
class Ticker {
 public:
  using Clock = std::chrono::steady_clock;

  Ticker(Clock::duration interval, std::function<void(Clock::time_point)> tick);
  // Waits for a tick that is running.
  ~Ticker();
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;

 private:
  void Run();

  const Clock::duration interval_;
  const std::function<void(Clock::time_point)> tick_;
  Mutex mutex_;
  CondVar stopped_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace curvd
