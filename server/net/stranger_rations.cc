#include "server/net/stranger_rations.h"

#include <algorithm>

#include "server/net/receive_valve.h"
#include "server/net/tcp_counts.h"

namespace curvd {
namespace {

// What is left of `all` if `taken` is taken from it.
uint64_t Rest(uint64_t all, uint64_t taken) { return all - std::min(all, taken); }

}  // namespace

uint64_t StrangerRations::left() const { return Rest(total_, held_); }

uint64_t StrangerRations::More(const Ration& ration) const {
  const uint64_t of_newcomers = Rest(total_ / kNewcomersMost, held_by_newcomers_);
  const uint64_t common = Rest(left(), std::min(total_ / kNewcomersShare, of_newcomers));
  // What is left beside newcomers at least, or nobody might ever get it.
  const uint64_t call = std::min(call_bytes_, total_ / kNewcomersMost + kNewcomerBytes);
  const bool is_newcomer = ration.used() < kNewcomerBytes;
  // Who goes on gets a whole call's bytes: if many held parts of calls, none could end.
  const uint64_t needed = std::max(ration.used() + 1, is_newcomer ? kNewcomerBytes : call);
  const uint64_t least = Rest(needed, ration.grant), whole = Rest(call, ration.grant);
  const uint64_t beside_a_call = Rest(common, std::max(call, total_ / kNewcomersShare));
  const uint64_t available = is_newcomer ? std::max(std::min(left(), of_newcomers), beside_a_call) : common;
  const bool others_wait = newcomers_.size() + others_.size() > (ration.waits ? 1 : 0);
  const bool is_scarce = others_wait || scarce_since_.has_value();
  // Of much, what it does not use is taken back.
  uint64_t much = 0;
  if (needed > call) {
    much = common / 2;
  } else if (!is_scarce && whole <= common) {
    much = std::max(common / 2, whole);
  }
  const uint64_t more = std::min(std::max(least <= available ? least : 0, much), most_ - ration.grant);
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
  ration.cut_since = now;
  ration.received = CountsOf(fd).received;
  const uint64_t grant = More(ration);
  if (grant == 0) {
    Queue(fd, ration);
    return false;
  }
  ration.inside = true;
  SetGrant(ration, grant);
  Bound(fd, ration);
  return true;
}

void StrangerRations::SetGrant(Ration& ration, uint64_t grant) {
  held_ += grant - ration.grant;
  const auto of_newcomer = [](uint64_t bytes) { return bytes <= kNewcomerBytes ? bytes : 0; };
  held_by_newcomers_ += of_newcomer(grant) - of_newcomer(ration.grant);
  ration.grant = grant;
}

void StrangerRations::Lift(int fd) {
  const auto found = rations_.find(fd);
  if (found == rations_.end()) return;
  if (found->second.waits) {
    std::erase(newcomers_, fd);
    std::erase(others_, fd);
    if (newcomers_.empty() && others_.empty()) scarce_since_.reset();
  }
  SetGrant(found->second, 0);
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
  ration.kept_until = std::min(ration.kept_until, now + kShortestPause);  // more of it may be on its way
}

// Bytes that take the place of others, which were accounted for, make nobody younger.
void StrangerRations::NoteRead(Ration& ration, uint64_t read, Clock::time_point now) {
  ration.read = read;
  const uint64_t held = ration.held_by_grpc();
  if (held > ration.most_held) {
    const double new_part = static_cast<double>(held - ration.most_held) / static_cast<double>(held);
    ration.holds_since += std::chrono::duration_cast<Clock::duration>((now - ration.holds_since) * new_part);
    ration.most_held = held;
  }
  if (held == 0) ration.most_held = 0;
}

StrangerRations::Use StrangerRations::Note(int fd, uint64_t received, uint64_t read, uint64_t accounted,
                                           Clock::time_point now) {
  const auto found = rations_.find(fd);
  if (found == rations_.end()) return Use::kPart;
  Ration& ration = found->second;
  NoteReceived(ration, received, now);
  NoteRead(ration, read, now);
  if (!ration.inside) return ration.used() < most_ ? Use::kAll : Use::kTooMuch;
  const bool full = received >= ration.bound();
  if (full && !ration.is_cut) ration.cut_since = now;
  if (full || ration.changed == now) ration.is_cut = full;
  const uint64_t base = std::max(accounted, kGreetingBytes);
  if (base >= ration.base + std::min(kStepBytes, ration.grant / 4 + 1)) {
    if (full && ration.grant == most_) return Use::kTooMuch;
    ration.base = base;
    ration.kept_until = now;
    Bound(fd, ration);
    return Use::kPart;
  }
  if (!full) return Use::kPart;
  Queue(fd, ration);
  return Use::kAll;
}

bool StrangerRations::Serve(int fd, Clock::time_point now, Division& division) {
  Ration& ration = rations_.at(fd);
  if (ration.inside && ration.received < ration.bound()) {  // what it sent was accounted for meanwhile
    ration.waits = false;
    return true;
  }
  const uint64_t more = More(ration);
  if (more == 0) return false;
  ration.waits = false;
  SetGrant(ration, ration.grant + more);
  if (ration.promises < kPromises) {
    ++ration.promises;
    // Of those at the door who send much anybody may, without having said anything.
    const bool is_known = ration.inside || ration.used() < kNewcomerBytes;
    const Clock::duration pause = is_known ? now - ration.cut_since : Clock::duration::zero();
    ration.kept_until = now + std::min<Clock::duration>(pause, kLongestPause) + kShortestPause;
    ration.promised = std::min(ration.grant, std::max(call_bytes_, ration.used() + 1));
  }
  if (!ration.inside) division.enter.push_back(fd);
  ration.inside = true;
  Bound(fd, ration);  // last, as it may lift the ration: who does not wait is in no queue that Divide goes through
  return true;
}

StrangerRations::Division StrangerRations::Divide(Clock::time_point now) {
  ForgetEnded(now);
  Division division;
  // Who has sent 2 KiB by now is no newcomer any more; the others behind him need not wait for him.
  std::erase_if(newcomers_, [&](int fd) {
    const bool has_become_another = rations_.at(fd).used() >= kNewcomerBytes;
    if (has_become_another) others_.push_back(fd);
    return has_become_another;
  });
  for (; !newcomers_.empty() && Serve(newcomers_.back(), now, division); newcomers_.pop_back()) {
  }
  // Who needs less than those before him need not wait for them, nor who is inside for those at the door.
  for (const bool inside : {true, false}) {
    std::erase_if(others_, [&](int fd) { return rations_.at(fd).inside == inside && Serve(fd, now, division); });
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

uint64_t StrangerRations::KnockBytes() const {
  return std::clamp(total_ / kSilentShare / (rations_.size() + 1), kLeastKnockBytes, kNewcomerBytes / 2);
}

// Bytes may have come before the system was told, and count.
void StrangerRations::TakeBackUnused(Clock::time_point now) {
  if (now - taken_back_ < kTakeBackInterval) return;
  taken_back_ = now;
  const uint64_t knock = KnockBytes();
  for (auto& [fd, ration] : rations_) {
    const uint64_t promised = now < ration.kept_until ? ration.promised : 0;
    const uint64_t kept = std::max(ration.used() + knock, promised);
    const bool is_silent = now - ration.changed >= kSilence || now - ration.since >= kStay;
    if (!ration.inside || !is_silent || kept >= ration.grant) continue;
    const uint64_t before = ration.grant;
    SetGrant(ration, kept);
    if (!BoundReceived(fd, ration.beginning, ration.bound())) {
      SetGrant(ration, before);
      continue;
    }
    NoteReceived(ration, CountsOf(fd).received, now);
    SetGrant(ration, std::max(kept, ration.used()));
  }
}

std::optional<int> StrangerRations::WhoHasToGo(Clock::time_point now) {
  const bool others_should = now - *scarce_since_ >= kScarcity && ended_bytes_ <= total_ / 2;
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
