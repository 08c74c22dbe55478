#include "server/net/stranger_rations.h"

#include <algorithm>

#include "server/net/receive_valve.h"
#include "server/net/tcp_counts.h"

namespace curvd {

uint64_t StrangerRations::More(const Ration& ration, size_t sharers) const {
  const uint64_t kept = total_ / kNewcomersShare;
  const uint64_t common = left() - std::min(left(), kept);
  // Less would not let it go on.
  const uint64_t needed = std::max(ration.used() + 1, ration.inside ? 0 : kNewcomerBytes);
  const uint64_t least = needed - std::min(needed, ration.grant);
  const bool is_newcomer = ration.used() < kNewcomerBytes;
  const uint64_t newcomers =
      is_newcomer ? std::min(left(), kNewcomerBytes - std::min(kNewcomerBytes, ration.grant)) : 0;
  const uint64_t more =
      std::min(most_ - ration.grant, std::max({common / (1 + sharers), std::min(common, least), newcomers}));
  return more >= least ? more : 0;
}

void StrangerRations::Bound(int fd, const Ration& ration) {
  if (!BoundReceived(fd, ration.beginning, ration.bound())) Lift(fd);
}

bool StrangerRations::Add(int fd, Clock::time_point now) {
  const std::optional<uint32_t> beginning = BeginningOf(fd);
  if (!beginning.has_value()) return true;
  ForgetEnded(now);
  if (left() < most_) TakeBackUnused(now);
  Ration& ration = rations_.emplace(fd, Ration{*beginning, now, now, now}).first->second;
  if (!BoundReceived(fd, ration.beginning, ration.bound())) {
    Lift(fd);
    return true;
  }
  ration.received = CountsOf(fd).received;
  const uint64_t grant = More(ration, newcomers_.size() + others_.size() + 1);
  if (grant == 0) {
    Queue(fd, ration);
    return false;
  }
  ration.inside = true;
  Give(ration, grant);
  Bound(fd, ration);
  return true;
}

void StrangerRations::Give(Ration& ration, uint64_t more) {
  ration.grant += more;
  held_ += more;
}

void StrangerRations::Lift(int fd) {
  const auto found = rations_.find(fd);
  if (found == rations_.end()) return;
  if (found->second.waits) {
    std::erase(newcomers_, fd);
    std::erase(others_, fd);
  }
  held_ -= found->second.grant;
  rations_.erase(found);
  LiftBound(fd);
}

void StrangerRations::End(int fd, Clock::time_point now) {
  const auto found = rations_.find(fd);
  if (found == rations_.end()) return;
  const uint64_t used = found->second.inside ? found->second.used() : 0;
  Lift(fd);
  held_ += used;
  ended_bytes_ += used;
  ended_.push_back({now, used});
}

void StrangerRations::ForgetEnded(Clock::time_point now) {
  for (; !ended_.empty() && now - ended_.front().at >= kAftermath; ended_.pop_front()) {
    held_ -= ended_.front().bytes;
    ended_bytes_ -= ended_.front().bytes;
  }
}

void StrangerRations::Queue(int fd, Ration& ration) {
  if (ration.waits || (ration.inside && ration.grant >= most_)) return;
  ration.waits = true;
  (ration.used() < kNewcomerBytes ? newcomers_ : others_).push_back(fd);
}

void StrangerRations::NoteReceived(Ration& ration, uint64_t received, Clock::time_point now) {
  if (received == ration.received) return;
  ration.received = received;
  ration.changed = now;
  ration.kept_until = now;
}

StrangerRations::Use StrangerRations::Note(int fd, uint64_t received, uint64_t read, uint64_t accounted,
                                           Clock::time_point now) {
  const auto found = rations_.find(fd);
  if (found == rations_.end()) return Use::kPart;
  Ration& ration = found->second;
  NoteReceived(ration, received, now);
  const uint64_t held_before = ration.held_by_grpc();
  ration.read = read;
  if (const uint64_t held = ration.held_by_grpc(); held > held_before) {
    const double new_part = static_cast<double>(held - held_before) / static_cast<double>(held);
    ration.holds_since += std::chrono::duration_cast<Clock::duration>((now - ration.holds_since) * new_part);
  }
  if (!ration.inside) return ration.used() < most_ ? Use::kAll : Use::kTooMuch;
  const bool full = received >= ration.bound();
  const uint64_t base = std::max(accounted, kGreetingBytes);
  if (base >= ration.base + std::min(kStepBytes, ration.grant / 4 + 1)) {
    if (full && ration.grant == most_) return Use::kTooMuch;
    ration.base = base;
    Bound(fd, ration);
    return Use::kPart;
  }
  if (!full) return Use::kPart;
  Queue(fd, ration);
  return Use::kAll;
}

bool StrangerRations::Serve(int fd, Clock::time_point now, Division& division) {
  Ration& ration = rations_.at(fd);
  const uint64_t more = More(ration, newcomers_.size() + others_.size());
  if (more == 0) return false;
  ration.waits = false;
  Give(ration, more);
  ration.kept_until = now + std::min<Clock::duration>(now - ration.changed, kLongestPause) + kShortestPause;
  if (!ration.inside) division.enter.push_back(fd);
  ration.inside = true;
  Bound(fd, ration);
  return true;
}

StrangerRations::Division StrangerRations::Divide(Clock::time_point now) {
  ForgetEnded(now);
  Division division;
  for (; !newcomers_.empty() && Serve(newcomers_.back(), now, division); newcomers_.pop_back()) {
  }
  for (; !others_.empty() && Serve(others_.front(), now, division); others_.pop_front()) {
  }
  if (newcomers_.empty() && others_.empty()) {
    scarce_since_.reset();
    return division;
  }
  if (!scarce_since_.has_value()) scarce_since_ = now;
  TakeBackUnused(now);
  division.end = WhoHasToGo(now);
  return division;
}

// Bytes may have come before the system was told, and count.
void StrangerRations::TakeBackUnused(Clock::time_point now) {
  if (now - taken_back_ < kWait) return;
  taken_back_ = now;
  for (auto& [fd, ration] : rations_) {
    const uint64_t promised = now < ration.kept_until ? std::min(ration.grant, kNewcomerBytes) : 0;
    const uint64_t kept = std::max(ration.used() + kKnockBytes, promised);
    const bool is_silent = now - ration.changed >= kSilence || now - ration.since >= kStay;
    if (ration.waits || !ration.inside || !is_silent || kept >= ration.grant) continue;
    held_ -= ration.grant;
    ration.grant = kept;
    BoundReceived(fd, ration.beginning, ration.bound());
    NoteReceived(ration, CountsOf(fd).received, now);
    ration.grant = std::max(kept, ration.used());
    held_ += ration.grant;
  }
}

std::optional<int> StrangerRations::WhoHasToGo(Clock::time_point now) {
  const bool others_should = now - *scarce_since_ >= kWait && ended_bytes_ <= total_ / 2;
  std::optional<int> found;
  double most = 0.0;
  uint64_t held_for_long = 0;
  for (const auto& [fd, ration] : rations_) {
    if (!ration.inside && now - ration.since >= kDoorPatience) return fd;
    const std::chrono::duration<double> stay = now - ration.holds_since;
    if (stay >= kStay) held_for_long += ration.held_by_grpc();
    const double held = static_cast<double>(ration.held_by_grpc()) * stay.count();
    if (held <= most) continue;
    most = held;
    // Nobody has to go before who has held most has done so for long enough: others might be honest, and slow.
    found = others_should && stay >= kStay ? std::optional(fd) : std::nullopt;
  }
  return held_for_long >= total_ / kHoldersShare ? found : std::nullopt;
}

}  // namespace curvd
