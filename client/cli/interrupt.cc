#include "client/cli/interrupt.h"

#include <unistd.h>

#include <cstdio>

#include "client/cli/command.h"
#include "client/io/atomic_file.h"

namespace curv {
namespace {

constexpr int kEndWatch = SIGUSR1;

}  // namespace

InterruptWatch::InterruptWatch() {
  sigemptyset(&watched_);
  for (const int signal : {SIGINT, SIGTERM, kEndWatch}) sigaddset(&watched_, signal);
  pthread_sigmask(SIG_BLOCK, &watched_, &before_);
  thread_ = std::thread([this] { Watch(); });
}

InterruptWatch::~InterruptWatch() {
  pthread_kill(thread_.native_handle(), kEndWatch);
  thread_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void InterruptWatch::Watch() {
  int signal = 0;
  while (sigwait(&watched_, &signal) == 0 && signal != kEndWatch) {
    if (source_.stop_requested()) _exit(static_cast<int>(ExitCode::kInterrupted));
    source_.request_stop();
    const std::lock_guard lock(mutex_);
    EndIfAllowed();
  }
}

void InterruptWatch::EndIfAllowed() const {
  if (ends_at_once_ == 0 || !source_.stop_requested()) return;
  std::fputs("curv: interrupted\n", stderr);
  _exit(static_cast<int>(ExitCode::kInterrupted));
}

InterruptWatch::EndsAtOnce::EndsAtOnce(const InterruptWatch& watch, bool applies) : watch_(applies ? &watch : nullptr) {
  if (watch_ == nullptr) return;
  const std::lock_guard lock(watch_->mutex_);
  ++watch_->ends_at_once_;
  watch_->EndIfAllowed();
}

InterruptWatch::EndsAtOnce::~EndsAtOnce() {
  if (watch_ == nullptr) return;
  const std::lock_guard lock(watch_->mutex_);
  --watch_->ends_at_once_;
}

UninterruptedWrite::UninterruptedWrite(const std::string& output) : at_once_(watch_, IsWrittenDirectly(output)) {}

}  // namespace curv
