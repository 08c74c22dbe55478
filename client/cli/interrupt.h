// Turns Ctrl-C into a stop token, so that an interrupted command tidies up.
#pragma once

#include <signal.h>

#include <stop_token>
#include <thread>

namespace curv {

// While it lives, the first SIGINT or SIGTERM requests a stop; the second ends the process at once with code 130.
// At most one at a time. Threads that are to run on must be started while it lives: they inherit its signal mask.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  void Watch();

  sigset_t watched_;
  sigset_t before_;
  std::stop_source source_;
  std::thread thread_;
};

}  // namespace curv
