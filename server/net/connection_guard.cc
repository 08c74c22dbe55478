#include "server/net/connection_guard.h"

#include <algorithm>
#include <utility>

namespace curvd {

void ConnectionGuard::Wake(int watch) {
  awake_.push_back({watch, 0});
  next_turn_ = std::min(next_turn_, last_turn_ + kInterval);
}

void ConnectionGuard::Forget(int watch) {
  const auto found = std::find_if(awake_.begin(), awake_.end(), [watch](const Awake& a) { return a.watch == watch; });
  if (found != awake_.end()) awake_.erase(found);
  debtors_.erase(watch);
}

int ConnectionGuard::WaitMs(Clock::time_point now) const {
  if (awake_.empty() && debtors_.empty() && level_ == MemoryPressure::Level::kFine) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(next_turn_ - now);
  return static_cast<int>(std::clamp<std::chrono::milliseconds::rep>(left.count(), 0, kSlowInterval.count()));
}

ConnectionGuard::Sights ConnectionGuard::Turn(Clock::time_point now, uint64_t resident_bytes) {
  Sights sights;
  if (now < next_turn_) return sights;
  last_turn_ = now;
  level_ = memory_.Judge(resident_bytes);
  sights.quiet = LookAtAwake(now);
  LookAtDebtors(now);
  ShareAmongStrangers(resident_bytes);
  ConnectionRegistry::Division division = connections_.DivideAmongStrangers(now);
  if (division.ended) memory_.NoteFreed(now);
  sights.enter = std::move(division.enter);
  Shed(now);
  const bool is_tense = level_ != MemoryPressure::Level::kFine;
  const auto interval = awake_.empty() && !is_tense ? kSlowInterval : kLongInterval;
  next_turn_ = now + (saw_strangers_ || is_tense ? kInterval : interval);
  return sights;
}

std::vector<int> ConnectionGuard::LookAtAwake(Clock::time_point now) {
  std::vector<int> quiet;
  saw_strangers_ = false;
  for (size_t looks = std::min(kLooksInTurn, awake_.size()); looks > 0; --looks) {
    Awake next = awake_.front();
    awake_.pop_front();
    const ConnectionRegistry::Sight sight = connections_.Look(next.watch, now);
    if (sight == ConnectionRegistry::Sight::kEnded) memory_.NoteFreed(now);
    saw_strangers_ = saw_strangers_ || connections_.IsStranger(next.watch);
    const bool in_vain = sight == ConnectionRegistry::Sight::kQuiet || sight == ConnectionRegistry::Sight::kOwes;
    next.looks_in_vain = in_vain ? next.looks_in_vain + 1 : 0;
    if (next.looks_in_vain < kQuietLooks) {
      awake_.push_back(next);
    } else {
      quiet.push_back(next.watch);
      if (sight == ConnectionRegistry::Sight::kOwes) debtors_.insert(next.watch);
    }
  }
  return quiet;
}

// A debtor stays one while bytes come, since nobody may be told of these bytes again: they were seen here.
void ConnectionGuard::LookAtDebtors(Clock::time_point now) {
  if (now < debtors_due_) return;
  debtors_due_ = now + kSlowInterval;
  std::erase_if(debtors_, [&](int watch) {
    const ConnectionRegistry::Sight sight = connections_.Look(watch, now);
    if (sight == ConnectionRegistry::Sight::kEnded) memory_.NoteFreed(now);
    return sight == ConnectionRegistry::Sight::kEnded || sight == ConnectionRegistry::Sight::kQuiet;
  });
}

void ConnectionGuard::ShareAmongStrangers(uint64_t resident_bytes) {
  connections_.ShareAmongStrangers(memory_.Headroom(resident_bytes) / kWorstGrowth);
}

void ConnectionGuard::Shed(Clock::time_point now) {
  const bool critical = level_ == MemoryPressure::Level::kCritical;
  // What the process freed and keeps is nobody's fault: that goes first, and the next turn shows what is left.
  const bool trimmed = level_ != MemoryPressure::Level::kFine && memory_.Trim(now);
  bool any = false;
  if (level_ == MemoryPressure::Level::kHigh && !trimmed) {
    any = connections_.EndLargestStranger();
    any = connections_.EndStrangersBeyond(kStrangersTogether) || any;
  }
  while (critical && connections_.EndLargestStranger()) any = true;
  if (critical && !trimmed) {
    any = connections_.EndStrangersBeyond(kSparedTogether) || any;
    any = connections_.EndLargestLetIn(kSparedLetInBytes) || any;
  }
  if (any) memory_.NoteFreed(now);
  refuses_ = critical && (any || refuses_);
}

}  // namespace curvd
