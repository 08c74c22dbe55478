// Says whether others may go before a reservation that waits for memory.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

namespace curvd {

// A large reservation that waits must neither be passed by smaller ones for ever, nor keep memory from them for ever:
// 1. It lets others pass until they have taken as many bytes as it wants itself.
// 2. From then on it claims what becomes free: nobody passes, for kFirstClaim.
// 3. If it could not be served by then, it rests and lets others pass, for as long as it claimed.
// 4. It claims again, for twice as long, and so on, up to kLongestClaim.
// So others wait at most for half of the time; and it is served at the latest when the calls that hold memory as a
// claim begins end before the claim does.
//
// The time is what the caller says it is, and never goes back. Not thread-safe.
class WaitingClaim {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration kFirstClaim = std::chrono::seconds(5);
  static constexpr Clock::duration kLongestClaim = std::chrono::seconds(80);

  explicit WaitingClaim(uint64_t wanted_bytes) : wanted_(wanted_bytes) {}

  // Somebody else wants to be served first. Returns whether that is all right; a refusal begins the claim.
  bool LetsPass(Clock::time_point now) {
    if (passed_ < wanted_) return true;
    if (has_begun_ && now >= began_ + 2 * length_) {
      has_begun_ = false;
      length_ = std::min(2 * length_, kLongestClaim);
    }
    if (!has_begun_) began_ = now;
    has_begun_ = true;
    return now >= began_ + length_;
  }
  // Somebody else was served first.
  void CountPassed(uint64_t bytes) { passed_ += bytes; }

  // Since when it claims; nothing if it does not claim now.
  std::optional<Clock::time_point> ClaimsSince(Clock::time_point now) const {
    if (!has_begun_ || now >= began_ + length_) return std::nullopt;
    return began_;
  }

 private:
  const uint64_t wanted_;
  uint64_t passed_ = 0;
  Clock::duration length_ = kFirstClaim;
  bool has_begun_ = false;
  Clock::time_point began_{};  // of the latest claim, which may be over
};

}  // namespace curvd
