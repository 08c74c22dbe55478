#include "server/net/byte_account.h"

#include <algorithm>
#include <utility>

#include "server/net/stranger_rations.h"

namespace curvd {
namespace {

// What a call costs beside its metadata and messages: frames of HTTP/2, records of TLS, pings, windows.
constexpr uint64_t kCallBytes = 256;
constexpr uint64_t kMessageBytes = 64;
constexpr uint64_t kMessageShare = 16;
// What a peer sends for the bytes that it takes: two updates of its windows for each frame of 16 KiB at worst, 13 bytes
// each, in a record of TLS, and an answer to a ping now and then.
constexpr uint64_t kSentShare = 128;
// What a call without a token accounts for at most. Metadata is counted unpacked, and HTTP/2 packs it: a call of a few
// bytes, which anybody may make, must not account for much else.
constexpr uint64_t kAnsweredMetadata = 1 << 10;
// What a client may send for a call before it hears that the call is refused, or that it shall go on: HTTP/2's window.
constexpr uint64_t kFirstFlightBytes = 64 << 10;
// What a connection sends that has nothing to do: pings, each of which gets an answer as long as itself. A header that
// never ends gets none. Who was let in may also break off some calls a second.
constexpr uint64_t kForgivenBytesPerSecond = 64;
constexpr uint64_t kForgivenSentTimes = 2;
constexpr uint64_t kForgivenLetInBytesPerSecond = 4 << 10;
// What an open call that everybody may make counts for: gRPC holds 17 KiB for it.
constexpr uint64_t kOpenToAllBytes = 256;

}  // namespace

void ByteAccount::NoteLetIn() {
  let_in_ = true;
  ++open_;
}

void ByteAccount::NoteMessage(uint64_t bytes, bool is_first) {
  accounted_ += bytes + bytes / kMessageShare + kMessageBytes;
  if (is_first) ++reading_;
}

void ByteAccount::NoteSent(uint64_t bytes) { accounted_ += bytes / kSentShare + kMessageBytes; }

// What was on its way when the call ended, nobody reads any more.
void ByteAccount::NoteEnd(const EndedCall& call) {
  if (open_ == 0) return;
  --open_;
  if (call.messages == 0 && call.broken_off) return;
  accounted_ += call.metadata + kCallBytes + kFirstFlightBytes;
  if (call.messages == 0 || reading_ == 0) return;
  --reading_;
  accounted_ += std::max(allowances_->max_message, kOversizedBytes);
}

// What it sends with a call that is refused counts against what strangers may send: it should not do so often.
void ByteAccount::NoteAnswered(uint64_t metadata) { accounted_ += std::min(metadata, kAnsweredMetadata) + kCallBytes; }

void ByteAccount::Forgive(uint64_t sent, Clock::time_point now) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - forgiven_at_);
  if (seconds.count() == 0) return;
  forgiven_at_ += seconds;
  const uint64_t answered = kForgivenSentTimes * (sent - std::exchange(forgiven_sent_, sent));
  const auto elapsed = static_cast<uint64_t>(seconds.count());
  accounted_ +=
      let_in_ ? elapsed * kForgivenLetInBytesPerSecond : std::min(elapsed * kForgivenBytesPerSecond, answered);
}

uint64_t ByteAccount::allowance() const {
  if (!let_in_) return allowances_->stranger;
  return allowances_->let_in + open_ * (kFirstFlightBytes + allowances_->max_metadata) +
         reading_ * allowances_->max_message + (reading_ > 0 ? kOversizedBytes : 0);
}

ByteAccount::Verdict ByteAccount::Judge(uint64_t read, uint64_t sent, Clock::time_point now) {
  Forgive(sent, now);
  // Credit is not saved up; but what was on its way to calls that have ended may come later.
  accounted_ = std::min(accounted_, read + (let_in_ ? std::max(allowances_->max_message, kOversizedBytes) : 0));
  unaccounted_ = read - std::min(read, accounted_) + open_to_all_ * kOpenToAllBytes;
  if (!let_in_) return JudgeStranger(now);
  return unaccounted_ > allowance() ? Verdict::kTooMuch : Verdict::kFine;
}

ByteAccount::Verdict ByteAccount::JudgeStranger(Clock::time_point now) {
  if (unaccounted_ <= kSmallBytes) owes_since_.reset();
  if (unaccounted_ > kSmallBytes && !owes_since_.has_value()) owes_since_ = now;
  if (owes_since_.has_value() && now - *owes_since_ > allowances_->patience()) return Verdict::kTooMuch;
  // The system moves its bound in steps.
  if (unaccounted_ + StrangerRations::kStepBytes < allowances_->stranger) {
    suspect_since_.reset();
    return owes_since_.has_value() ? Verdict::kOwes : Verdict::kFine;
  }
  if (!suspect_since_.has_value()) suspect_since_ = now;
  // More than the system should have let through: it does not hold the bound.
  const bool unbounded = unaccounted_ > 2 * allowances_->stranger;
  return unbounded || now - *suspect_since_ > kPatience ? Verdict::kTooMuch : Verdict::kSuspect;
}

}  // namespace curvd
