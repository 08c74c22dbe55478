#include "server/rpc/bidi_stream.h"

#include <utility>

#include "absl/time/time.h"
#include "server/rpc/ending_errors.h"

namespace curvd {
namespace {

absl::Status StallError(StreamState::Stall stall, absl::Duration limit) {
  const bool is_slow = stall == StreamState::Stall::kSendsSlowly || stall == StreamState::Stall::kTakesSlowly;
  const bool for_room_to_send =
      stall == StreamState::Stall::kWithoutRoomToSend || stall == StreamState::Stall::kTakesSlowly;
  return is_slow ? CallerIsSlow(for_room_to_send, PeerPace::kMinBytesPerSecond, limit)
                 : CallerStalls(for_room_to_send, limit);
}

}  // namespace

void BidiStream::Start() {
  const absl::StatusOr<Caller>& caller = account_.caller();
  absl::Status status = caller.ok() ? service_.gate.Open(shared_from_this(), *caller) : caller.status();
  if (status.ok()) {
    ReadNext();
  } else {
    End(std::move(status));
  }
}

void BidiStream::ReadNext() {
  {
    MutexLock lock(mutex_);
    if (!state_.StartRead(Clock::now())) return;
    state_.Hold();
  }
  transport_.StartRead(&incoming_);
  Release();
}

void BidiStream::OnReadDone(bool ok) {
  {
    MutexLock lock(mutex_);
    if (!state_.EndRead(Clock::now())) return;
  }
  if (!ok) return ReceiveEnd();
  account_.CountReceived(incoming_.Length());
  Receive(incoming_);
}

void BidiStream::CountProgress(uint64_t bytes) {
  MutexLock lock(mutex_);
  state_.CountReceived(bytes);
}

void BidiStream::JudgeWrites() {
  MutexLock lock(mutex_);
  state_.JudgeWrites(Clock::now());
}

void BidiStream::WriteNext() {
  for (bool again = true; again;) {
    StreamState::Step step = StreamState::Step::kNothing;
    {
      MutexLock lock(mutex_);
      step = state_.Next();
    }
    if (step == StreamState::Step::kNothing) return;
    if (step == StreamState::Step::kFinish) return Finish();
    const Made made = MakeMessage(outgoing_);
    if (made == Made::kMessage) return Send();
    {
      MutexLock lock(mutex_);
      again = state_.SkipWrite();
    }
    if (made == Made::kLast) return End(absl::OkStatus());
  }
}

void BidiStream::Send() {
  account_.CountSent(outgoing_.Length());
  {
    MutexLock lock(mutex_);
    state_.StartWrite(Clock::now());
  }
  transport_.StartWrite(&outgoing_);
}

void BidiStream::Finish() {
  absl::Status outcome;
  {
    MutexLock lock(mutex_);
    outcome = *state_.outcome();
  }
  // The caller learns now how the call ended, and may open another in its place.
  service_.gate.FreePlace(this);
  transport_.Finish(account_.ToCaller(outcome));
}

void BidiStream::OnWriteDone(bool ok) {
  {
    MutexLock lock(mutex_);
    state_.EndWrite(Clock::now(), outgoing_.Length());
  }
  if (ok) {
    WriteNext();
  } else {
    End(account_.CallerGoneNow());
  }
}

void BidiStream::OnCancel() {
  {
    MutexLock lock(mutex_);
    state_.NoteCancel();
  }
  End(account_.CallerGoneNow());
}

void BidiStream::End(absl::Status outcome) {
  bool is_first = false;
  {
    MutexLock lock(mutex_);
    is_first = state_.End(std::move(outcome));
    if (is_first) {
      state_.Hold();
      state_.JudgeWrites(Clock::now());
    }
  }
  if (!is_first) return WriteNext();
  Stop();
  Release();
}

void BidiStream::Release() {
  {
    MutexLock lock(mutex_);
    if (!state_.Release()) return;
  }
  WriteNext();
}

void BidiStream::Tick(Clock::time_point now) {
  StreamState::Stall stall = StreamState::Stall::kNone;
  bool is_writing = false;
  const bool is_missed = IsMissed();
  {
    MutexLock lock(mutex_);
    stall = state_.FindStall(now, absl::ToChronoNanoseconds(service_.stall_timeout), is_missed);
    is_writing = state_.is_writing();
  }
  if (stall != StreamState::Stall::kNone) return EndStalled(stall);
  OnTick(now, is_writing);
  WriteNext();
}

void BidiStream::EndStalled(StreamState::Stall stall) {
  bool must_cancel = false;
  {
    MutexLock lock(mutex_);
    must_cancel = state_.is_writing();
    if (must_cancel) state_.Hold();
  }
  End(StallError(stall, service_.stall_timeout));
  if (!must_cancel) return;
  transport_.TryCancel();  // a status would wait behind the write
  Release();
}

void BidiStream::OnDone() {
  absl::Status status;
  {
    MutexLock lock(mutex_);
    status = state_.outcome().value_or(absl::UnknownError("the call ended without an outcome"));
    // A stream that broke off looks like a half-close, and a status that was sent may not have arrived.
    const bool may_be_broken_off = status.ok() || absl::IsInvalidArgument(status);
    if (state_.is_cancelled() && may_be_broken_off) status = account_.CallerGoneNow();
  }
  CompleteRecord(account_.record());
  account_.Close(std::move(status));
  service_.gate.Close(this);
}

}  // namespace curvd
