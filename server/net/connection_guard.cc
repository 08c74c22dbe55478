#include "server/net/connection_guard.h"

#include <algorithm>

namespace curvd {

void ConnectionGuard::Wake(int watch) {
  awake_.push_back({watch, 0});
  next_turn_ = std::min(next_turn_, last_turn_ + kInterval);
}

void ConnectionGuard::Forget(int watch) {
  const auto found = std::find_if(awake_.begin(), awake_.end(), [watch](const Awake& a) { return a.watch == watch; });
  if (found != awake_.end()) awake_.erase(found);
}

int ConnectionGuard::WaitMs(Clock::time_point now) const {
  if (awake_.empty() && level_ == MemoryPressure::Level::kFine) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(next_turn_ - now);
  return static_cast<int>(std::clamp<std::chrono::milliseconds::rep>(left.count(), 0, kLongInterval.count()));
}

std::vector<int> ConnectionGuard::Turn(Clock::time_point now, uint64_t resident_bytes) {
  std::vector<int> quiet;
  if (now < next_turn_) return quiet;
  last_turn_ = now;
  bool strangers = false;
  level_ = memory_.Judge(resident_bytes);
  for (size_t looks = std::min(kLooksInTurn, awake_.size()); looks > 0; --looks) {
    Awake next = awake_.front();
    awake_.pop_front();
    const ConnectionRegistry::Sight sight = connections_.Look(next.watch, now);
    if (sight == ConnectionRegistry::Sight::kEnded) memory_.NoteFreed(now);
    strangers = strangers || connections_.IsStranger(next.watch);
    next.looks_in_vain = sight == ConnectionRegistry::Sight::kQuiet ? next.looks_in_vain + 1 : 0;
    if (next.looks_in_vain < kQuietLooks) {
      awake_.push_back(next);
    } else {
      quiet.push_back(next.watch);
    }
  }
  Shed(now, resident_bytes);
  next_turn_ = now + (strangers || level_ != MemoryPressure::Level::kFine ? kInterval : kLongInterval);
  return quiet;
}

void ConnectionGuard::Shed(Clock::time_point now, uint64_t resident_bytes) {
  const bool critical = level_ == MemoryPressure::Level::kCritical;
  // What the process freed and keeps is nobody's fault: that goes first, and the next turn shows what is left.
  const bool trimmed = level_ != MemoryPressure::Level::kFine && memory_.Trim(now);
  const uint64_t budget = std::max(kStrangersBytes, memory_.Headroom(resident_bytes) / kWorstGrowth);
  bool any = level_ == MemoryPressure::Level::kHigh && !trimmed && connections_.EndLargestStranger();
  while ((critical || connections_.StrangersBytes() > budget) && connections_.EndLargestStranger()) any = true;
  if (critical && !trimmed && connections_.EndLargestLetIn(kSparedLetInBytes)) any = true;
  if (any) memory_.NoteFreed(now);
  refuses_ = critical && (any || refuses_);
}

}  // namespace curvd
