#include "server/rpc/stream_state.h"

#include <utility>

namespace curvd {

bool StreamState::StartRead(Clock::time_point now) {
  if (outcome_.has_value()) return false;
  read_in_flight_ = true;
  read_started_ = now;
  return true;
}

bool StreamState::EndRead() {
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
  write_started_ = now;
}

bool StreamState::SkipWrite() {
  writer_ = Writer::kIdle;
  return was_asked_again_;
}

void StreamState::EndWrite() { writer_ = Writer::kIdle; }

bool StreamState::End(absl::Status outcome) {
  if (outcome_.has_value()) return false;
  outcome_ = std::move(outcome);
  return true;
}

bool StreamState::Release() {
  --holds_;
  return outcome_.has_value();
}

StreamState::Stall StreamState::FindStall(Clock::time_point now, Clock::duration limit) const {
  if (writer_ == Writer::kInFlight && now - write_started_ > limit) return Stall::kWithoutRoomToSend;
  const bool waits_for_message = read_in_flight_ && !outcome_.has_value();
  return waits_for_message && now - read_started_ > limit ? Stall::kWithoutMessage : Stall::kNone;
}

}  // namespace curvd
