// Plays any sequence of events to the state machines of the answering side, and a driver that breaks no rule.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "server/call/response_session.h"
#include "server/rpc/stream_state.h"
#include "tests/fuzz/input.h"
#include "tests/fuzz/require.h"

namespace {

using curvd::ResponseSession;
using curvd::StreamState;
using Kind = ResponseSession::Kind;
using Step = StreamState::Step;

constexpr uint64_t kChunkPoints = 7;
constexpr auto kLimit = std::chrono::seconds(3);

// A call as the peer sees it: what was written, in order.
class Written {
 public:
  void Take(const ResponseSession::Message& message, uint64_t points) {
    fuzz::Require(!has_summary_, "nothing follows the summary");
    fuzz::Require(has_accepted_ == (message.kind != Kind::kAccepted), "Accepted comes first, and once");
    has_accepted_ = true;
    if (message.kind == Kind::kProgress) fuzz::Require(next_ == 0, "no Progress comes after results");
    if (message.kind == Kind::kResults) {
      fuzz::Require(message.first == next_ && message.count > 0, "results have no gaps");
      fuzz::Require(message.count <= kChunkPoints, "chunks are bounded");
      next_ += message.count;
    }
    if (message.kind != Kind::kSummary) return;
    fuzz::Require(next_ == points, "all results come before the summary");
    has_summary_ = true;
  }
  bool has_summary() const { return has_summary_; }

 private:
  bool has_accepted_ = false;
  bool has_summary_ = false;
  uint64_t next_ = 0;
};

// Drives both machines as BidiStream and EstimateCall do, one event at a time.
class Call {
 public:
  void Play(fuzz::Input& input) {
    const uint8_t event = input.Byte();
    switch (event % 9) {
      case 0:
        if (!is_accepted_) responses_.Accept();
        is_accepted_ = true;
        break;
      case 1:
        responses_.SetProgressDue(!state_.is_writing());
        break;
      case 2:
        if (is_accepted_ && !is_complete_) Complete(input.Byte());
        break;
      case 3:
        WriteNext();
        break;
      case 4:
        if (write_in_flight_) state_.EndWrite(now_, 1);
        write_in_flight_ = false;
        WriteNext();
        break;
      case 5:
        if (state_.End(absl::CancelledError("cancel"))) is_failed_ = true;
        JudgeWrites();
        WriteNext();
        break;
      case 6:
        state_.Hold();
        ++holds_;
        break;
      case 7:
        if (holds_ > 0 && (--holds_, state_.Release())) WriteNext();
        break;
      case 8:
        now_ += std::chrono::seconds(event / 9 % 4);
        Read();
        break;
    }
    CheckStalls();
  }

  // Lets everything in flight come to its end; the call must have finished then if it has an outcome.
  void Close() {
    while (holds_ > 0) --holds_, state_.Release();
    for (int i = 0; i < 1000 && !is_finished_; ++i) {
      if (write_in_flight_) state_.EndWrite(now_, 1);
      write_in_flight_ = false;
      WriteNext();
    }
    fuzz::Require(is_finished_ == state_.outcome().has_value(), "a call with an outcome finishes");
    fuzz::Require(is_finished_ || !is_complete_, "a call whose cloud is estimated finishes");
    fuzz::Require(!is_finished_ || is_failed_ || written_.has_summary(), "a call that ends with OK had its summary");
  }

 private:
  void Complete(uint64_t points) {
    responses_.Complete(points_ = points, kChunkPoints);
    is_complete_ = true;
    JudgeWrites();
  }

  void JudgeWrites() {
    state_.JudgeWrites(now_);
    if (!judged_from_.has_value()) judged_from_ = now_;
  }

  void WriteNext() {
    const Step step = state_.Next();
    if (step == Step::kFinish) {
      fuzz::Require(!is_finished_ && !write_in_flight_ && holds_ == 0, "a call finishes once, with nothing in flight");
      is_finished_ = true;
    }
    if (step != Step::kMakeMessage) return;
    fuzz::Require(!write_in_flight_ && !state_.outcome().has_value(), "no message is made ahead, or after the end");
    const ResponseSession::Message message = responses_.Next();
    if (message.kind == Kind::kNothing || message.kind == Kind::kEnd) {
      fuzz::Require(!state_.SkipWrite(), "nobody has asked meanwhile");
      if (message.kind == Kind::kEnd && state_.End(absl::OkStatus())) WriteNext();
      return;
    }
    written_.Take(message, points_);
    state_.StartWrite(now_);
    write_started_ = now_;
    write_in_flight_ = true;
  }

  void Read() {
    if (read_in_flight_) {
      fuzz::Require(state_.EndRead(now_) != state_.outcome().has_value(), "what comes after the end is dropped");
      read_in_flight_ = false;
    }
    if (state_.StartRead(now_)) {
      fuzz::Require(!state_.outcome().has_value(), "nothing is read after the end");
      read_in_flight_ = true;
    }
  }

  void CheckStalls() {
    const bool is_stuck =
        write_in_flight_ && judged_from_.has_value() && now_ - std::max(write_started_, *judged_from_) > kLimit;
    fuzz::Require((state_.FindStall(now_, kLimit) == StreamState::Stall::kWithoutRoomToSend) == is_stuck,
                  "a write that takes too long is noticed once the peer must take it, and not before");
  }

  StreamState state_;
  ResponseSession responses_;
  Written written_;
  bool is_accepted_ = false;
  bool is_complete_ = false;
  bool is_failed_ = false;
  bool is_finished_ = false;
  bool read_in_flight_ = false;
  bool write_in_flight_ = false;
  int holds_ = 0;
  uint64_t points_ = 0;
  StreamState::Clock::time_point now_;
  StreamState::Clock::time_point write_started_;
  std::optional<StreamState::Clock::time_point> judged_from_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  fuzz::Input input(bytes, size);
  Call call;
  while (!input.empty()) call.Play(input);
  call.Close();
  return 0;
}
