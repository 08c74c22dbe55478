#include "server/rpc/stream_state.h"

#include <utility>

namespace curvd {

bool StreamState::StartRead(Clock::time_point now) {
  if (outcome_.has_value()) return false;
  read_in_flight_ = true;
  reading_.StartWait(now);
  return true;
}

bool StreamState::EndRead(Clock::time_point now) {
  reading_.EndWait(now);
  read_in_flight_ = false;
  return !outcome_.has_value();
}

StreamState::Step StreamState::Next() {
  if (writer_ != Writer::kIdle) {
    was_asked_again_ = true;
    return Step::kNothing;
  }
  if (is_finished_) return Step::kNothing;
  if (outcome_.has_value()) {
    if (holds_ > 0) return Step::kNothing;
    is_finished_ = true;
    return Step::kFinish;
  }
  writer_ = Writer::kMakesMessage;
  was_asked_again_ = false;
  return Step::kMakeMessage;
}

void StreamState::StartWrite(Clock::time_point now) {
  writer_ = Writer::kInFlight;
  writing_.StartWait(now);
}

bool StreamState::SkipWrite() {
  writer_ = Writer::kIdle;
  return was_asked_again_;
}

void StreamState::EndWrite(Clock::time_point now, uint64_t bytes) {
  writer_ = Writer::kIdle;
  writing_.EndWait(now);
  writing_.CountProgress(bytes);
}

bool StreamState::End(absl::Status outcome) {
  if (outcome_.has_value()) return false;
  outcome_ = std::move(outcome);
  return true;
}

bool StreamState::Release() {
  --holds_;
  return outcome_.has_value();
}

void StreamState::JudgeWrites(Clock::time_point now) {
  if (std::exchange(judges_writes_, true)) return;
  writing_.StartAnew(now);
}

StreamState::Stall StreamState::FindStall(Clock::time_point now, Clock::duration limit, bool is_missed) {
  using Verdict = PeerPace::Verdict;
  if (!is_missed) {
    reading_.CapLag(now, limit / 2);
    writing_.CapLag(now, limit / 2);
  }
  const bool waits_for_room = writer_ == Writer::kInFlight && judges_writes_;
  const Verdict taking = waits_for_room ? writing_.Judge(now, limit) : Verdict::kFine;
  if (taking == Verdict::kStalled) return Stall::kWithoutRoomToSend;
  const bool waits_for_message = read_in_flight_ && !outcome_.has_value();
  const Verdict sending = waits_for_message ? reading_.Judge(now, limit) : Verdict::kFine;
  if (sending == Verdict::kStalled) return Stall::kWithoutMessage;
  if (!is_missed) return Stall::kNone;
  if (taking == Verdict::kSlow) return Stall::kTakesSlowly;
  return sending == Verdict::kSlow ? Stall::kSendsSlowly : Stall::kNone;
}

}  // namespace curvd
