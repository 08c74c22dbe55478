#include "server/estimate_stream.h"

#include <grpcpp/server_context.h>

#include <algorithm>
#include <utility>

#include "absl/time/time.h"
#include "server/call_errors.h"
#include "server/call_summary.h"
#include "server/result_encoder.h"
#include "server/rpc_status.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

// Clouds up to this size go before larger ones, block by block.
constexpr uint64_t kInteractivePoints = 100'000;

double SecondsSince(EstimateStream::Clock::time_point start) {
  return std::chrono::duration<double>(EstimateStream::Clock::now() - start).count();
}

// The deadline counts from the call's arrival here. The caller's own clock started earlier, so that its cancel may
// arrive a little before our deadline.
bool DeadlineHasPassed(const grpc::CallbackServerContext& call) {
  constexpr auto kSlack = std::chrono::milliseconds(50);
  return std::chrono::system_clock::now() + kSlack >= call.deadline();
}

v1::Progress::Phase ProgressPhase(JobPhase phase) {
  switch (phase) {
    case JobPhase::kQueued:
      return v1::Progress::PHASE_QUEUED;
    case JobPhase::kIndexing:
      return v1::Progress::PHASE_INDEXING;
    case JobPhase::kEstimating:
      return v1::Progress::PHASE_ESTIMATING;
    case JobPhase::kDone:
      return v1::Progress::PHASE_SENDING;
  }
  return v1::Progress::PHASE_SENDING;
}

}  // namespace

EstimateStream* EstimateStream::Start(ServiceContext& service, grpc::CallbackServerContext& call) {
  const auto stream = std::make_shared<EstimateStream>(service, call);
  stream->self_ = stream;
  service.metrics.CountStarted(RpcMethod::kEstimateCurvature);
  absl::Status status = service.gate.Open(stream);
  if (status.ok()) {
    stream->ReadNext();
  } else {
    stream->End(std::move(status));
  }
  return stream.get();
}

EstimateStream::EstimateStream(ServiceContext& service, grpc::CallbackServerContext& call)
    : service_(service), call_(call), session_(service.limits), started_(Clock::now()) {
  receive_started_ = last_read_ = last_write_ = started_;
  record_.request_id = service.request_ids.Next();
  record_.peer = call.peer();
}

// ---- reading

void EstimateStream::ReadNext() {
  {
    MutexLock lock(mutex_);
    if (outcome_.has_value()) return;
    read_in_flight_ = true;
    last_read_ = Clock::now();
    ++holds_;
  }
  StartRead(&request_);
  ReleaseHold();
}

void EstimateStream::OnReadDone(bool ok) {
  {
    MutexLock lock(mutex_);
    read_in_flight_ = false;
    if (outcome_.has_value()) return;
  }
  if (ok) {
    Receive();
  } else {
    OnHalfClose();
  }
}

void EstimateStream::Receive() {
  const uint64_t bytes = request_.ByteSizeLong();
  ++record_.messages_received;
  record_.bytes_received += bytes;
  service_.metrics.CountReceived(RpcMethod::kEstimateCurvature, bytes);
  const bool is_header = !session_.has_header();
  if (absl::Status status = session_.Receive(request_); !status.ok()) return End(std::move(status));
  request_.Clear();
  record_.points_received = session_.points_received();
  points_received_.store(session_.points_received(), std::memory_order_relaxed);
  if (is_header) {
    OnHeaderAccepted();
  } else {
    ReserveThenRead();
  }
}

void EstimateStream::OnHeaderAccepted() {
  const CallOptions& options = session_.options();
  receive_started_ = Clock::now();
  record_.request_tag = options.request_tag;
  auto reservation = service_.admission.Enter(options.point_count, options.scalar_type, options.estimator.estimator);
  if (!reservation.ok()) return End(reservation.status());
  {
    MutexLock lock(mutex_);
    if (outcome_.has_value()) return;
    reservation_ = *std::move(reservation);
    accepted_due_ = true;
  }
  Pump();
  ReserveThenRead();
}

// A chunk is in the cloud before its memory is reserved; what is reserved always covers one more chunk.
void EstimateStream::ReserveThenRead() {
  const CallOptions& options = session_.options();
  const bool size_is_known = options.point_count != 0;
  const uint64_t points = size_is_known ? options.point_count : session_.points_received();
  const uint64_t bytes =
      service_.admission.CallBytes(points, options.scalar_type, options.estimator.estimator, !size_is_known);
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    reservation = reservation_;
  }
  wait_started_ = Clock::now();
  const absl::StatusOr<bool> granted = reservation->GrowTo(
      bytes, [self = shared_from_this()](absl::Status status) { self->OnMemoryGranted(std::move(status)); });
  if (!granted.ok()) return End(granted.status());
  if (*granted) ReadNext();
}

void EstimateStream::OnMemoryGranted(absl::Status status) {
  if (!status.ok()) return End(std::move(status));
  {
    MutexLock lock(mutex_);
    if (outcome_.has_value()) return;
    record_.seconds.admit += SecondsSince(wait_started_);
  }
  ReadNext();
}

void EstimateStream::OnHalfClose() {
  if (absl::Status status = session_.HalfClose(); !status.ok()) return End(std::move(status));
  record_.normals_rescaled = session_.normals_rescaled();
  record_.seconds.receive = SecondsSince(receive_started_) - record_.seconds.admit;
  StartJob();
}

void EstimateStream::StartJob() {
  const JobPriority priority =
      session_.points_received() <= kInteractivePoints ? JobPriority::kInteractive : JobPriority::kBatch;
  auto done = [self = shared_from_this()](absl::StatusOr<EstimationResult> result) {
    self->OnJobDone(std::move(result));
  };
  std::shared_ptr<EstimationJob> job = EstimationJob::Start(session_.TakeCloud(), session_.options().estimator,
                                                            service_.pool, priority, std::move(done));
  bool cancel = false;
  {
    MutexLock lock(mutex_);
    cancel = outcome_.has_value();
    if (!cancel && !field_ready_) job_ = job;
  }
  if (cancel) job->Cancel();
}

void EstimateStream::OnJobDone(absl::StatusOr<EstimationResult> result) {
  std::shared_ptr<EstimationJob> job;
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    job = std::move(job_);
    if (outcome_.has_value()) return;
    if (result.ok()) {
      field_ = std::move(result->field);
      record_.status_counts = field_.status_counts;
      record_.peak_bytes = result->cost.peak_bytes;
      record_.seconds.queue = result->cost.queue_seconds;
      record_.seconds.index = result->cost.index_seconds;
      record_.seconds.estimate = result->cost.estimate_seconds;
      send_started_ = Clock::now();
      field_ready_ = true;
      reservation = reservation_;
    }
  }
  if (!result.ok()) return End(ExplainJobError(result.status()));
  reservation->ShrinkTo(service_.admission.SendingBytes(field_.points.size()));
  Pump();
}

// ---- writing

void EstimateStream::Pump() {
  Write write = Write::kNone;
  absl::Status outcome;
  {
    MutexLock lock(mutex_);
    write = PickWrite();
    if (write == Write::kNone) return;
    if (write == Write::kFinish) {
      finish_called_ = true;
      outcome = *outcome_;
    } else {
      write_in_flight_ = true;
    }
  }
  if (write == Write::kFinish) {
    Finish(ToGrpcStatus(outcome, record_.request_id));
  } else {
    FillResponse(write);
    SendResponse();
  }
}

void EstimateStream::SendResponse() {
  const uint64_t bytes = response_.ByteSizeLong();
  ++record_.messages_sent;
  record_.bytes_sent += bytes;
  service_.metrics.CountSent(RpcMethod::kEstimateCurvature, bytes);
  {
    MutexLock lock(mutex_);
    last_write_ = Clock::now();
  }
  StartWrite(&response_);
}

EstimateStream::Write EstimateStream::PickWrite() {
  if (write_in_flight_ || finish_called_) return Write::kNone;
  if (outcome_.has_value()) return holds_ == 0 ? Write::kFinish : Write::kNone;
  if (std::exchange(accepted_due_, false)) return Write::kAccepted;
  if (field_ready_) {
    if (next_point_ < field_.points.size()) return Write::kResults;
    if (!std::exchange(summary_written_, true)) return Write::kSummary;
    outcome_ = absl::OkStatus();
    return holds_ == 0 ? Write::kFinish : Write::kNone;
  }
  return std::exchange(progress_due_, false) ? Write::kProgress : Write::kNone;
}

void EstimateStream::FillResponse(Write write) {
  switch (write) {
    case Write::kAccepted:
      return FillAccepted(session_.options(), service_.limits, record_.request_id, response_.mutable_accepted());
    case Write::kProgress:
      return FillProgress();
    case Write::kResults:
      return FillResults();
    case Write::kSummary:
      return FillSummary();
    case Write::kNone:
    case Write::kFinish:
      return;
  }
}

void EstimateStream::FillProgress() {
  v1::Progress* progress = response_.mutable_progress();
  std::shared_ptr<EstimationJob> job;
  {
    MutexLock lock(mutex_);
    job = job_;
  }
  const JobProgress state = job == nullptr ? JobProgress() : job->progress();
  progress->set_phase(job == nullptr ? v1::Progress::PHASE_RECEIVING : ProgressPhase(state.phase));
  progress->set_points_received(points_received_.load(std::memory_order_relaxed));
  progress->set_points_estimated(state.points_estimated);
}

void EstimateStream::FillResults() {
  const uint64_t count = std::min<uint64_t>(kResultChunkPoints, field_.points.size() - next_point_);
  EncodeResults(field_.points, next_point_, count, session_.options().quantities, response_.mutable_result());
  next_point_ += count;
}

void EstimateStream::FillSummary() {
  record_.seconds.send = SecondsSince(send_started_);
  curvd::FillSummary(record_, response_.mutable_summary());
}

void EstimateStream::OnWriteDone(bool ok) {
  {
    MutexLock lock(mutex_);
    write_in_flight_ = false;
  }
  if (ok) {
    Pump();
  } else {
    End(CallerGone(DeadlineHasPassed(call_)));
  }
}

// ---- ending

void EstimateStream::End(absl::Status status) {
  std::shared_ptr<EstimationJob> job;
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    if (!outcome_.has_value()) {
      outcome_ = std::move(status);
      job = job_;
      reservation = reservation_;
    }
  }
  if (job != nullptr) job->Cancel();
  if (reservation != nullptr) reservation->Abandon();
  Pump();
}

void EstimateStream::OnCancel() {
  {
    MutexLock lock(mutex_);
    cancelled_ = true;
  }
  End(CallerGone(DeadlineHasPassed(call_)));
}

void EstimateStream::OnDone() {
  std::shared_ptr<EstimateStream> self;
  {
    MutexLock lock(mutex_);
    self = std::move(self_);
    record_.status = outcome_.value_or(absl::UnknownError("the call ended without an outcome"));
    // A stream that broke off looks like a half-close, and a status that was sent may not have arrived.
    const bool may_be_broken_off = record_.status.ok() || absl::IsInvalidArgument(record_.status);
    if (cancelled_ && may_be_broken_off) record_.status = CallerGone(DeadlineHasPassed(call_));
  }
  record_.total_seconds = SecondsSince(started_);
  service_.metrics.CountHandled(RpcMethod::kEstimateCurvature, record_.status.code(), record_.total_seconds);
  service_.metrics.CountCall(record_);
  service_.log.LogCall(record_);
  service_.gate.Close(this);
}

bool EstimateStream::Stalls(Clock::time_point now) const {
  if (outcome_.has_value()) return false;
  const auto limit = absl::ToChronoNanoseconds(service_.stall_timeout);
  return (read_in_flight_ && now - last_read_ > limit) || (write_in_flight_ && now - last_write_ > limit);
}

void EstimateStream::Tick(Clock::time_point now) {
  bool stalls = false;
  {
    MutexLock lock(mutex_);
    stalls = Stalls(now);
    // Before the header is accepted there is nothing to tell, and Accepted comes first.
    progress_due_ = reservation_ != nullptr && !write_in_flight_;
  }
  if (stalls) return EndStalled();
  Pump();
}

void EstimateStream::EndStalled() {
  bool must_cancel = false;
  {
    MutexLock lock(mutex_);
    must_cancel = write_in_flight_;
    if (must_cancel) ++holds_;
  }
  End(CallerStalls(must_cancel, service_.stall_timeout));
  if (!must_cancel) return;
  call_.TryCancel();  // a status would wait behind the write
  ReleaseHold();
}

void EstimateStream::ReleaseHold() {
  {
    MutexLock lock(mutex_);
    --holds_;
    if (!outcome_.has_value()) return;
  }
  Pump();
}

}  // namespace curvd
