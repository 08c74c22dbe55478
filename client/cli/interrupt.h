// Turns Ctrl-C into a stop token, so that an interrupted command tidies up.
#pragma once

#include <signal.h>

#include <mutex>
#include <stop_token>
#include <string>
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

  // While it lives, the first signal, also one that has come before, ends the process at once with code 130. For what
  // waits for others and does not look at the token, as the open or the read of a pipe.
  // REQUIRES: the watch outlives it, and nothing is held that must be tidied up, as a temporary file.
  class EndsAtOnce {
   public:
    // Does nothing unless `applies`.
    explicit EndsAtOnce(const InterruptWatch& watch, bool applies = true);
    ~EndsAtOnce();
    EndsAtOnce(const EndsAtOnce&) = delete;
    EndsAtOnce& operator=(const EndsAtOnce&) = delete;

   private:
    const InterruptWatch* const watch_;  // null if it does not apply
  };

  std::stop_token token() const { return source_.get_token(); }

 private:
  void Watch();
  // Ends the process if a stop was requested while an EndsAtOnce lives. The lock is held until the process is gone, so
  // that none ends meanwhile.
  // REQUIRES: the caller holds the lock.
  void EndIfAllowed() const;

  sigset_t watched_;
  sigset_t before_;
  std::stop_source source_;
  mutable std::mutex mutex_;      // guards what follows
  mutable int ends_at_once_ = 0;  // how many EndsAtOnce there are
  std::thread thread_;
};

// For commands that otherwise leave signals to the system. While it lives, the first SIGINT or SIGTERM lets `output` be
// written to its end, so that no temporary file stays behind (AtomicFile); where output is written to directly, which
// may wait for a reader, it ends the process at once with code 130.
class UninterruptedWrite {
 public:
  explicit UninterruptedWrite(const std::string& output);

 private:
  const InterruptWatch watch_;
  const InterruptWatch::EndsAtOnce at_once_;
};

}  // namespace curv
