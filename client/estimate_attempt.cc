#include "client/estimate_attempt.h"

#include <algorithm>
#include <cstdint>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/request_encoder.h"
#include "client/result_collector.h"
#include "client/rpc_error.h"
#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "grpcpp/generic/generic_stub.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
using Phase = EstimateProgress::Phase;

// gRPC keeps its address.
const std::string& Method() {
  static const std::string& method = *new std::string("/curvature.v1.CurvatureService/EstimateCurvature");
  return method;
}

Phase PhaseOf(const v1::Progress& progress) {
  switch (progress.phase()) {
    case v1::Progress::PHASE_QUEUED:
      return Phase::kQueued;
    case v1::Progress::PHASE_INDEXING:
      return Phase::kIndexing;
    case v1::Progress::PHASE_ESTIMATING_NORMALS:
      return Phase::kMakingNormals;
    case v1::Progress::PHASE_ORIENTING:
      return Phase::kOrienting;
    case v1::Progress::PHASE_ESTIMATING:
      return Phase::kEstimating;
    case v1::Progress::PHASE_SENDING:
      return Phase::kReceiving;
    default:
      return Phase::kSending;
  }
}

// A call as a sequence of events, which gRPC reports to the calling thread: at most one read and one write are under
// way.
class Attempt {
 public:
  Attempt(const CloudView& cloud, const EstimateOptions& options, const EstimateCallbacks& callbacks, int attempt)
      : cloud_(cloud), options_(options), callbacks_(callbacks), collector_(cloud.size(), options) {
    progress_.points = cloud.size();
    progress_.attempt = attempt;
  }

  // gRPC may still write to this object until every event has come, also when a callback threw.
  ~Attempt() {
    if (events_under_way_ > 0) context_.TryCancel();
    while (events_under_way_ > 0) NextEvent();
    events_.Shutdown();
    NextEvent();
  }

  AttemptOutcome Run(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout) {
    if (timeout != absl::InfiniteDuration()) context_.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
    const std::stop_callback cancel(callbacks_.stop, [this] { context_.TryCancel(); });
    Report([](EstimateProgress&) {});
    stream_ = grpc::GenericStub(channel).PrepareCall(&context_, Method(), &events_);
    stream_->StartCall(Expect(Event::kStarted));
    while (events_under_way_ > 0) {
      const auto [event, ok] = NextEvent();
      Handle(event, ok);
    }
    return Conclude();
  }

 private:
  enum class Event : intptr_t { kStarted = 1, kWritten, kRead, kFinished };

  void* Expect(Event event) {
    ++events_under_way_;
    return reinterpret_cast<void*>(event);
  }

  std::pair<Event, bool> NextEvent() {
    void* tag = nullptr;
    bool ok = false;
    if (events_.Next(&tag, &ok)) --events_under_way_;
    return {static_cast<Event>(reinterpret_cast<intptr_t>(tag)), ok};
  }

  void Handle(Event event, bool ok) {
    switch (event) {
      case Event::kStarted:
        Write(PackHeader(cloud_, options_), grpc::WriteOptions());
        stream_->Read(&response_, Expect(Event::kRead));
        return;
      case Event::kWritten:
        return OnWritten(ok);
      case Event::kRead:
        return OnRead(ok);
      case Event::kFinished:
        return;
    }
  }

  void OnWritten(bool ok) {
    is_writing_ = false;
    if (!ok) {
      is_half_closed_ = true;  // the stream has ended; its status tells why
      return;
    }
    Report([&](EstimateProgress& progress) {
      if (next_point_ > 0) progress.phase = std::max(progress.phase, Phase::kSending);
      progress.points_sent = next_point_;
    });
    WriteNext();
  }

  void OnRead(bool ok) {
    if (!ok) {
      is_half_closed_ = true;  // nobody hears more
      stream_->Finish(&status_, Expect(Event::kFinished));
      return;
    }
    // What comes after a broken message is read away.
    if (broken_.ok()) {
      broken_ = Take();
      if (!broken_.ok()) context_.TryCancel();
    }
    response_.Clear();
    stream_->Read(&response_, Expect(Event::kRead));
    if (!broken_.ok()) return;
    Report([this](EstimateProgress& progress) {
      progress.points_received = collector_.points_received();
      progress.points_estimated = collector_.progress().points_estimated();
      const Phase phase = progress.points_received > 0 ? Phase::kReceiving : PhaseOf(collector_.progress());
      progress.phase = std::max(progress.phase, phase);
    });
    WriteNext();
  }

  absl::Status Take() {
    try {
      return collector_.Take(response_);
    } catch (const std::bad_alloc&) {
      return absl::ResourceExhaustedError(absl::StrCat("no memory for the results of ", cloud_.size(), " points"));
    }
  }

  // Nothing but the header before the server has accepted it.
  void WriteNext() {
    if (is_writing_ || is_half_closed_ || !collector_.accepted()) return;
    const uint64_t allowed = collector_.limits().max_chunk_bytes();
    if (next_point_ == cloud_.size() || allowed == 0) {
      is_half_closed_ = is_writing_ = true;
      stream_->WritesDone(Expect(Event::kWritten));
      return;
    }
    const uint64_t chunk_bytes = std::min<uint64_t>(allowed, options_.chunk_bytes);
    const size_t chunk_points = std::max<size_t>(1, chunk_bytes / (cloud_.array_count() * cloud_.point_bytes()));
    const size_t count = std::min(chunk_points, cloud_.size() - next_point_);
    grpc::Slice chunk = PackChunk(cloud_, next_point_, count);
    next_point_ += count;
    is_half_closed_ = next_point_ == cloud_.size();
    grpc::WriteOptions options;
    if (is_half_closed_) options.set_last_message();
    Write(chunk, options);
  }

  void Write(const grpc::Slice& message, grpc::WriteOptions options) {
    is_writing_ = true;
    stream_->Write(grpc::ByteBuffer(&message, 1), options, Expect(Event::kWritten));
  }

  template <typename Change>
  void Report(const Change& change) {
    change(progress_);
    if (callbacks_.on_progress) callbacks_.on_progress(progress_);
  }

  AttemptOutcome Conclude() {
    if (!broken_.ok()) return {std::nullopt, {broken_, std::nullopt, true}};
    if (!status_.ok()) {
      const bool answered = collector_.accepted() || !status_.error_details().empty();
      return {std::nullopt, {ToAbslStatus(status_), RetryDelay(status_), answered}};
    }
    if (absl::Status finish = collector_.Finish(); !finish.ok()) return {std::nullopt, {finish, std::nullopt, true}};
    return {collector_.Release(), {}};
  }

  const CloudView& cloud_;
  const EstimateOptions& options_;
  const EstimateCallbacks& callbacks_;
  grpc::CompletionQueue events_;
  int events_under_way_ = 0;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;

  bool is_writing_ = false;
  bool is_half_closed_ = false;
  size_t next_point_ = 0;  // to be sent
  grpc::ByteBuffer response_;
  ResultCollector collector_;
  absl::Status broken_;
  grpc::Status status_;
  EstimateProgress progress_;
};

}  // namespace

AttemptOutcome RunAttempt(const std::shared_ptr<grpc::Channel>& channel, const CloudView& cloud,
                          const EstimateOptions& options, absl::Duration timeout, int attempt,
                          const EstimateCallbacks& callbacks) {
  return Attempt(cloud, options, callbacks, attempt).Run(channel, timeout);
}

}  // namespace curv
