#include "server/call/estimate_stream.h"

#include <grpcpp/server_context.h>

#include <utility>

#include "absl/time/time.h"
#include "server/access/call_credentials.h"
#include "server/call/job_errors.h"

namespace curvd {
namespace {

// When `deadline` comes, given that it is `now`.
EstimateStream::Clock::time_point OnSteadyClock(std::chrono::system_clock::time_point deadline,
                                                EstimateStream::Clock::time_point now) {
  if (deadline == std::chrono::system_clock::time_point::max()) return EstimateStream::Clock::time_point::max();
  return now + (deadline - std::chrono::system_clock::now());
}

}  // namespace

EstimateStream* EstimateStream::Start(ServiceContext& service, grpc::CallbackServerContext& call) {
  const absl::StatusOr<Caller> caller = service.access.Identify(CredentialsOf(call));
  const auto stream = std::make_shared<EstimateStream>(service, call, caller.ok() ? *caller : Caller());
  stream->self_ = stream;
  service.metrics.CountStarted(RpcMethod::kEstimateCurvature);
  absl::Status status = caller.ok() ? service.gate.Open(stream, *caller) : caller.status();
  if (status.ok()) {
    stream->ReadNext();
  } else {
    stream->End(std::move(status));
  }
  return stream.get();
}

EstimateStream::EstimateStream(ServiceContext& service, grpc::CallbackServerContext& call, const Caller& caller)
    : service_(service),
      call_(call),
      limits_(LimitsFor(caller, service.limits)),
      session_(limits_),
      started_(Clock::now()),
      deadline_(OnSteadyClock(call.deadline(), started_)) {
  receive_started_ = last_read_ = last_write_ = started_;
  record_.request_id = service.request_ids.Next();
  record_.peer = call.peer();
  record_.caller = caller.name;
}

// The deadline counts from the call's arrival here. The caller's own clock started earlier, so that its cancel may
// arrive a little before our deadline.
absl::Status EstimateStream::GoneStatus() const {
  constexpr auto kSlack = std::chrono::milliseconds(50);
  return CallerGone(Clock::now() + kSlack >= deadline_);
}

void EstimateStream::End(absl::Status status) {
  std::shared_ptr<EstimationJob> job;
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    if (!outcome_.has_value()) {
      outcome_ = std::move(status);
      job = job_;
      reservation = reservation_;
      if (job != nullptr) RecordJob(job->progress());
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
  End(GoneStatus());
}

void EstimateStream::OnDone() {
  std::shared_ptr<EstimateStream> self;
  {
    MutexLock lock(mutex_);
    self = std::move(self_);
    record_.status = outcome_.value_or(absl::UnknownError("the call ended without an outcome"));
    // A stream that broke off looks like a half-close, and a status that was sent may not have arrived.
    const bool may_be_broken_off = record_.status.ok() || absl::IsInvalidArgument(record_.status);
    if (cancelled_ && may_be_broken_off) record_.status = GoneStatus();
    RecordLastPhase();
  }
  record_.total_seconds = SecondsSince(started_);
  service_.metrics.CountHandled(RpcMethod::kEstimateCurvature, record_.status.code(), record_.total_seconds);
  service_.metrics.CountCall(record_);
  service_.log.LogCall(record_);
  service_.gate.Close(this);
}

void EstimateStream::RecordJob(const JobProgress& job) {
  record_.seconds.queue = job.queue_seconds;
  record_.seconds.index = job.index_seconds;
  record_.seconds.estimate = job.estimate_seconds;
}

void EstimateStream::EndWait() {
  if (!waits_since_.has_value()) return;
  record_.seconds.admit = record_.seconds.admit.value_or(0.0) + SecondsSince(*waits_since_);
  waits_since_.reset();
}

void EstimateStream::RecordLastPhase() {
  EndWait();
  PhaseTimes& seconds = record_.seconds;
  if (seconds.admit.has_value() && !seconds.receive.has_value()) {
    seconds.receive = SecondsSince(receive_started_) - *seconds.admit;
  }
  if (field_ready_ && !seconds.send.has_value()) seconds.send = SecondsSince(send_started_);
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
