// The reading chain of EstimateStream: from the header to the job.
#include <utility>

#include "server/call/call_errors.h"
#include "server/call/estimate_stream.h"

namespace curvd {
namespace {

// Clouds up to this size go before larger ones, block by block, unless the caller says otherwise.
constexpr uint64_t kInteractivePoints = 100'000;

JobPriority PriorityOf(const CallOptions& options, uint64_t points) {
  if (options.priority.has_value()) return *options.priority;
  return points <= kInteractivePoints ? JobPriority::kInteractive : JobPriority::kBatch;
}

}  // namespace

void EstimateStream::ReadNext() {
  {
    MutexLock lock(mutex_);
    if (outcome_.has_value()) return;
    read_in_flight_ = true;
    last_read_ = Clock::now();
    ++holds_;
  }
  StartRead(&packed_request_);
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
  const uint64_t bytes = packed_request_.Length();
  ++record_.messages_received;
  record_.bytes_received += bytes;
  service_.metrics.CountReceived(RpcMethod::kEstimateCurvature, bytes);
  const bool is_header = !session_.has_header();
  if (absl::Status status = session_.Receive(packed_request_); !status.ok()) return End(std::move(status));
  packed_request_.Clear();
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
  auto reservation = service_.admission.Enter(options.point_count, options.scalar_type, options.estimator);
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
      service_.admission.CallBytes(points, options.scalar_type, options.estimator, !size_is_known);
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    reservation = reservation_;
    waits_since_ = Clock::now();
  }
  const absl::StatusOr<bool> granted = reservation->GrowTo(
      bytes, [self = shared_from_this()](absl::Status status) { self->OnMemoryGranted(std::move(status)); });
  if (granted.ok() && !*granted) return;
  {
    MutexLock lock(mutex_);
    waits_since_.reset();
    if (granted.ok()) record_.seconds.admit = record_.seconds.admit.value_or(0.0);
  }
  if (!granted.ok()) return End(granted.status());
  ReadNext();
}

void EstimateStream::OnMemoryGranted(absl::Status status) {
  if (!status.ok()) return End(std::move(status));
  {
    MutexLock lock(mutex_);
    if (outcome_.has_value()) return;
    EndWait();
  }
  ReadNext();
}

void EstimateStream::OnHalfClose() {
  if (absl::Status status = session_.HalfClose(); !status.ok()) return End(std::move(status));
  record_.normals_rescaled = session_.normals_rescaled();
  record_.seconds.receive = SecondsSince(receive_started_) - *record_.seconds.admit;
  StartJob();
}

void EstimateStream::StartJob() {
  const JobPriority priority = PriorityOf(session_.options(), session_.points_received());
  auto done = [self = shared_from_this()](absl::StatusOr<EstimationResult> result) {
    self->OnJobDone(std::move(result));
  };
  std::shared_ptr<EstimationJob> job = EstimationJob::Start(session_.TakeCloud(), session_.options().estimator,
                                                            service_.pool, priority, std::move(done));
  bool cancel = false;
  {
    MutexLock lock(mutex_);
    cancel = outcome_.has_value();
    if (cancel) RecordJob(job->progress());
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

}  // namespace curvd
