// Says which of the reservations that wait for memory may be served before others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "server/admission/waiting_claim.h"

namespace curvd {

// A reservation that waits, the first of its caller.
struct WaitingHead {
  WaitingClaim* claim = nullptr;
  uint64_t arrival = 0;       // no two are equal
  bool can_be_served = true;  // if all other callers left: else it holds up nobody
};

// One that may be served goes before all others. Those whose turn is earlier, or who came earlier, must let it pass
// (WaitingClaim), unless it claims memory and they do not, or do so since later. Each of those who are asked is asked
// once or twice, however many there are, unless several claim. Not thread-safe.
class PassingOrder {
 public:
  using Clock = WaitingClaim::Clock;

  // `heads` are in the order of their turns.
  PassingOrder(std::vector<WaitingHead> heads, Clock::time_point now) : heads_(std::move(heads)), now_(now) {
    for (size_t i = 0; i < heads_.size(); ++i) by_arrival_.push_back(i);
    std::sort(by_arrival_.begin(), by_arrival_.end(),
              [this](size_t a, size_t b) { return heads_[a].arrival < heads_[b].arrival; });
  }

  // Whether the head at `index` may be served, as far as the others are concerned. REQUIRES: `index` is larger than in
  // the call before.
  bool MayGo(size_t index) {
    if (heads_[index].claim->ClaimsSince(now_).has_value()) return ClaimsFirst(index);
    const uint64_t arrival = heads_[index].arrival;
    while (asked_in_turn_ < index && !HoldsUp(asked_in_turn_)) ++asked_in_turn_;
    if (asked_in_turn_ < index) return false;
    const auto came_before = [&] {
      return asked_by_arrival_ < by_arrival_.size() && heads_[by_arrival_[asked_by_arrival_]].arrival < arrival;
    };
    while (came_before() && !HoldsUp(by_arrival_[asked_by_arrival_])) ++asked_by_arrival_;
    return !came_before();
  }
  // Whether `other` goes before `next`, which passes it if it is served.
  bool Overtakes(size_t next, size_t other) const {
    return other < next || heads_[other].arrival < heads_[next].arrival;
  }

 private:
  // A claim asks only those who claim since earlier, and they do not let it pass.
  bool ClaimsFirst(size_t index) const {
    const auto since = *heads_[index].claim->ClaimsSince(now_);
    for (size_t other = 0; other < heads_.size(); ++other) {
      if (other == index || !heads_[other].can_be_served || !Overtakes(index, other)) continue;
      const auto others = heads_[other].claim->ClaimsSince(now_);
      if (!others.has_value() || *others > since) continue;
      if (*others < since || heads_[other].arrival < heads_[index].arrival) return false;
    }
    return true;
  }
  bool HoldsUp(size_t other) { return heads_[other].can_be_served && !heads_[other].claim->LetsPass(now_); }

  std::vector<WaitingHead> heads_;
  const Clock::time_point now_;
  std::vector<size_t> by_arrival_;
  // Who was asked before these lets others pass.
  size_t asked_in_turn_ = 0;
  size_t asked_by_arrival_ = 0;
};

}  // namespace curvd
