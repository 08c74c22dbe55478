// Measures whether a peer brings or takes bytes fast enough.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace curvd {

// Looks at one direction of a stream, and counts only the time in which the peer is waited for. Progress is what the
// protocol calls so: the bytes of points, say, not of messages. Each byte of progress makes up for
// 1 / kMinBytesPerSecond seconds of waiting, and no more than was waited. Not thread-safe.
class PeerPace {
 public:
  using Clock = std::chrono::steady_clock;

  // What a peer has to keep up while others need what its call holds: a quarter of what a line of 64 kB/s carries.
  static constexpr int64_t kMinBytesPerSecond = 16 << 10;
  // A message without progress counts as if the peer had been waited for so much longer, since one that is sent all
  // the time is never waited for.
  static constexpr Clock::duration kEmptyMessage = std::chrono::milliseconds(10);

  enum class Verdict {
    kFine,
    kSlow,     // over `limit` behind the least pace
    kStalled,  // waited for over `limit` without any progress
  };

  // The peer is waited for from now on.
  void StartWait(Clock::time_point now) {
    waits_ = true;
    wait_started_ = now;
  }
  // A message came, or has gone. No effect if the peer is not waited for.
  void EndWait(Clock::time_point now) {
    const Clock::duration waited = WaitedSince(now);
    idle_ += waited;
    behind_ += waited;
    waits_ = false;
  }
  // The message made so many bytes of progress.
  void CountProgress(uint64_t bytes) {
    if (bytes == 0) {
      idle_ += kEmptyMessage;
      behind_ += kEmptyMessage;
      return;
    }
    idle_ = {};
    const std::chrono::duration<double> paid(static_cast<double>(bytes) / static_cast<double>(kMinBytesPerSecond));
    behind_ = paid >= behind_ ? Clock::duration::zero() : behind_ - std::chrono::duration_cast<Clock::duration>(paid);
  }

  // Nobody needs what the call holds now: the peer is from now on at most so far behind, so that it gets the time to
  // hurry when somebody comes.
  void CapLag(Clock::time_point now, Clock::duration most) { behind_ = std::min(behind_, most - WaitedSince(now)); }
  // What the peer did so far does not matter.
  void StartAnew(Clock::time_point now) {
    idle_ = behind_ = {};
    if (waits_) wait_started_ = now;
  }

  Verdict Judge(Clock::time_point now, Clock::duration limit) const {
    const Clock::duration waited = WaitedSince(now);
    if (idle_ + waited > limit) return Verdict::kStalled;
    return behind_ + waited > limit ? Verdict::kSlow : Verdict::kFine;
  }

 private:
  Clock::duration WaitedSince(Clock::time_point now) const {
    return waits_ ? std::max(now - wait_started_, Clock::duration::zero()) : Clock::duration::zero();
  }

  bool waits_ = false;
  Clock::time_point wait_started_{};
  Clock::duration idle_{};    // waited since the last progress
  Clock::duration behind_{};  // waited, less what progress has made up for
};

}  // namespace curvd
