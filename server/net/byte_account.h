// Weighs what a connection has sent against what its calls account for.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

namespace curvd {

// How much a connection may send that no call accounts for.
struct ByteAllowances {
  // Before a call was let in. DEFAULT: what ForMetadata says for 8 KiB.
  uint64_t stranger = ForMetadata(8 << 10);
  // After that. DEFAULT: some 2,000 calls that are broken off before they have sent a message.
  uint64_t let_in = 256 << 10;
  uint64_t max_message = 5 << 20;   // bytes of the largest message that a call may send
  uint64_t max_metadata = 8 << 10;  // bytes of one call's metadata, as HTTP/2 counts them

  // Of `stranger`, what only those need who answer the server's first messages, and say more than one call.
  static constexpr uint64_t kSlack = 16 << 10;
  // What a stranger needs whose call may have so much metadata: a TLS handshake with certificates (8 KiB), the
  // metadata, the 64 KiB of messages that HTTP/2 lets a client send before it hears of a server's windows, and kSlack.
  static constexpr uint64_t ForMetadata(uint64_t max_metadata) {
    return (8 << 10) + max_metadata + (64 << 10) + kSlack;
  }
  // What a call takes that has all metadata that it may have, with a TLS handshake (5 KiB with a client's certificate).
  uint64_t call() const { return max_metadata + (6 << 10); }
  // What all strangers together may send even where memory is short: less would keep one of them out for good.
  uint64_t strangers_together() const { return max_metadata + (12 << 10); }
  // For how long a stranger may have more than ByteAccount::kSmallBytes unaccounted for: as long as a line of 9.6
  // kbit/s takes for twice the metadata of a call, and 10 s.
  std::chrono::seconds patience() const { return std::chrono::seconds(10 + max_metadata / 512); }
};

// A call that was let in, when it is over.
struct EndedCall {
  uint64_t metadata = 0;    // its bytes, as HTTP/2 counts them
  uint64_t messages = 0;    // that were received
  bool broken_off = false;  // the caller ended it
};

// gRPC's HTTP/2 keeps what it has read of a call's headers or of a message until it is complete, and then the call is
// ours to see. So bytes that no call accounts for, for long, are bytes that a stranger makes gRPC keep. Not
// thread-safe.
class ByteAccount {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Verdict {
    kFine,
    kOwes,     // it has sent more than kSmallBytes, and has to get an answer within ByteAllowances::patience
    kSuspect,  // it has used up what strangers may send, and may just be waiting for its call to be let in
    kTooMuch,
  };
  // What a stranger sends with a TLS handshake and a small call.
  static constexpr uint64_t kSmallBytes = 12 << 10;
  // What a call that has memory may send beyond its messages: one that is too large is refused by its length, and the
  // caller told so, while what is on its way of it is read and thrown away.
  static constexpr uint64_t kOversizedBytes = 32 << 20;
  // For how long a suspect may stay one.
  static constexpr std::chrono::seconds kPatience{1};

  ByteAccount(const ByteAllowances& allowances, Clock::time_point now) : allowances_(&allowances), forgiven_at_(now) {}

  // A call was let in. It is open until NoteEnd.
  void NoteLetIn();
  // A message of an open call is complete. Its first is small; with it the call gets memory for larger ones.
  void NoteMessage(uint64_t bytes, bool is_first);
  // A message of an open call was sent to the peer, which answers with updates of its windows.
  void NoteSent(uint64_t bytes);
  // An open call is over. No effect if none is open: it came by an earlier connection of the same peer.
  void NoteEnd(const EndedCall& call);
  // A call with so much metadata that was not let in has got its answer: one that everybody may make, or a refusal.
  // REQUIRES: the peer did not break it off.
  void NoteAnswered(uint64_t metadata);
  // A call that everybody may make has begun, or is over, answered or not. While it is open, gRPC holds memory for it.
  void NoteOpenToAll() { ++open_to_all_; }
  // No effect if none is open, as for NoteEnd.
  void NoteOpenToAllEnd() { open_to_all_ -= open_to_all_ > 0 ? 1 : 0; }

  // `read` bytes of the peer were read by gRPC, and `sent` bytes were sent to it, each counted once. REQUIRES: none of
  // them goes back, nor does `now`.
  Verdict Judge(uint64_t read, uint64_t sent, Clock::time_point now);
  // What no call accounted for when Judge was called, and what open calls that everybody may make hold.
  uint64_t unaccounted() const { return unaccounted_; }
  // What calls, their answers and time have accounted for.
  uint64_t accounted() const { return accounted_; }
  bool let_in() const { return let_in_; }
  uint64_t allowance() const;
  // Whether a call with so much metadata shows that gRPC's limit did not hold.
  bool TooMuchMetadata(uint64_t metadata) const { return metadata > 2 * allowances_->max_metadata; }

 private:
  void Forgive(uint64_t sent, Clock::time_point now);
  Verdict JudgeStranger(Clock::time_point now);

  const ByteAllowances* allowances_;
  bool let_in_ = false;
  uint64_t open_ = 0;         // calls that were let in
  uint64_t reading_ = 0;      // of them
  uint64_t open_to_all_ = 0;  // calls that everybody may make
  uint64_t accounted_ = 0;
  uint64_t unaccounted_ = 0;
  Clock::time_point forgiven_at_;
  uint64_t forgiven_sent_ = 0;  // bytes that had been sent to the peer then
  std::optional<Clock::time_point> owes_since_;
  std::optional<Clock::time_point> suspect_since_;
};

}  // namespace curvd
