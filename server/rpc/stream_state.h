// Decides when a bidirectional stream reads, writes and ends; a state machine that knows neither gRPC nor any message.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/status.h"
#include "server/rpc/peer_pace.h"

namespace curvd {

// Whoever drives it reports each event, and it answers what may be done next:
// - At most one read and at most one write are in flight. A message is made only when it can be written at once, so
//   that a peer that reads slowly costs the memory of one message.
// - A stream has one outcome, the first that anybody gives it. From then on it starts no read and makes no message.
// - It finishes once: when it has an outcome, no write is in flight, and nobody holds it. A hold keeps the stream from
//   finishing while a call into gRPC has not returned, since gRPC may free its objects when the stream finishes.
// Not thread-safe.
class StreamState {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Step { kNothing, kMakeMessage, kFinish };
  enum class Stall { kNone, kWithoutMessage, kWithoutRoomToSend, kSendsSlowly, kTakesSlowly };

  // Returns whether a read may start; it is in flight then. REQUIRES: no read is in flight.
  bool StartRead(Clock::time_point now);
  // The read is over. Returns whether anybody still wants what it brought.
  bool EndRead(Clock::time_point now);
  // What was read brought the call on by so many bytes.
  void CountReceived(uint64_t bytes) { reading_.CountProgress(bytes); }

  // What the writing side is to do now. After kMakeMessage the driver makes a message and calls StartWrite, or finds
  // that nothing is due and calls SkipWrite; in between this returns kNothing to all others. kFinish comes once.
  Step Next();
  // The message is made and goes out.
  void StartWrite(Clock::time_point now);
  // There was nothing to write. Returns whether somebody has called Next meanwhile, who may know of something new: then
  // Next must be called again.
  bool SkipWrite();
  // The write, of `bytes` bytes, is over.
  void EndWrite(Clock::time_point now, uint64_t bytes);

  // Sets the outcome. Returns false, and changes nothing, if there is one.
  bool End(absl::Status outcome);
  void Hold() { ++holds_; }
  // Ends one hold. Returns whether the stream may now be able to finish: then Next must be called.
  bool Release();

  // The caller has cancelled, or went away.
  void NoteCancel() { is_cancelled_ = true; }

  // From now on the peer must take what is written: results, or what the outcome waits behind. Before, what is written
  // tells it how things stand, and a peer may well send all it has before it reads. Only the first call counts.
  void JudgeWrites(Clock::time_point now);
  // Whether the peer has kept the stream waiting for longer than `limit` without bringing or taking anything; or, if
  // `is_missed`, whether it has fallen behind PeerPace::kMinBytesPerSecond by more than `limit`. A peer is at most half
  // of `limit` behind when it becomes missed. A write counts also when there is an outcome, which would wait behind it
  // for ever; a read does not.
  Stall FindStall(Clock::time_point now, Clock::duration limit, bool is_missed = false);

  bool is_cancelled() const { return is_cancelled_; }
  bool is_writing() const { return writer_ != Writer::kIdle; }
  const std::optional<absl::Status>& outcome() const { return outcome_; }

 private:
  enum class Writer { kIdle, kMakesMessage, kInFlight };

  std::optional<absl::Status> outcome_;
  bool is_cancelled_ = false;
  bool is_finished_ = false;
  bool read_in_flight_ = false;
  Writer writer_ = Writer::kIdle;
  bool was_asked_again_ = false;  // while a message was being made
  bool judges_writes_ = false;
  int holds_ = 0;
  PeerPace reading_;
  PeerPace writing_;
};

}  // namespace curvd
