#include "server/call/estimate_call.h"

#include <grpc/support/log.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "core/base/out_of_memory.h"
#include "server/call/job_errors.h"
#include "server/call/progress_message.h"
#include "server/call/summary_message.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using Response = v1::EstimateCurvatureResponse;

// Clouds up to this size go before larger ones, block by block, unless the caller says otherwise.
constexpr uint64_t kInteractivePoints = 100'000;

// While others wait for memory, a call lends what it has reserved for points that have not come, if after this time it
// looks as if the rest of its points would take longer than that.
constexpr auto kLendAfter = std::chrono::seconds(2);
constexpr auto kNeededSoon = std::chrono::seconds(10);

// Where nothing changes, a message now and then shows proxies that the call is alive.
constexpr auto kProgressAtLeast = std::chrono::seconds(30);

JobPriority PriorityOf(const CallOptions& options, uint64_t points) {
  if (options.priority.has_value()) return *options.priority;
  return points <= kInteractivePoints ? JobPriority::kInteractive : JobPriority::kBatch;
}

// Nobody, if the call is not let in.
Caller CallerOf(const RpcAccount& account) { return account.caller().ok() ? *account.caller() : Caller(); }

void Pack(const Response& response, grpc::ByteBuffer& message) {
  message.Clear();
  bool own_buffer = false;
  GPR_ASSERT(grpc::SerializationTraits<Response>::Serialize(response, &message, &own_buffer).ok());
}

}  // namespace

EstimateCall::EstimateCall(ServiceContext& service, const RpcArrival& arrival, BidiTransport& transport)
    : BidiStream(service, RpcMethod::kEstimateCurvature, arrival, transport),
      limits_(LimitsFor(CallerOf(account()), service.limits)),
      turn_key_(TurnKey(CallerOf(account()))),
      requests_(limits_) {}

void EstimateCall::Receive(grpc::ByteBuffer& message) {
  const bool is_header = !requests_.has_header();
  if (absl::Status status = requests_.Receive(message); !status.ok()) return End(std::move(status));
  message.Clear();
  const uint64_t new_points = requests_.points_received() - account().record().points_received;
  // A header is as good as one byte; a chunk without points brings nothing.
  CountProgress(is_header ? 1 : new_points * requests_.options().point_bytes());
  account().record().points_received = requests_.points_received();
  points_received_.store(requests_.points_received(), std::memory_order_relaxed);
  if (is_header) {
    AcceptHeader();
  } else {
    ReserveThenRead();
  }
}

void EstimateCall::AcceptHeader() {
  const CallOptions& options = requests_.options();
  account().record().request_tag = options.request_tag;
  auto reservation = service().admission.Enter(options, turn_key_);
  if (!reservation.ok()) return End(reservation.status());
  {
    MutexLock lock(mutex_);
    if (has_stopped_) return;
    phases_.StartReceiving(Clock::now());
    reservation_ = *std::move(reservation);
    responses_.Accept();
  }
  WriteNext();
  ReserveThenRead();
}

// A chunk is in the cloud before its memory is reserved; what is reserved always covers one more chunk.
void EstimateCall::ReserveThenRead() {
  const CallOptions& options = requests_.options();
  const auto bytes_for = [&](uint64_t points, bool more_may_follow) {
    return service().admission.CallBytes(points, options, more_may_follow);
  };
  const bool size_is_known = options.point_count != 0;
  const uint64_t so_far = bytes_for(requests_.points_received(), true);
  const uint64_t bytes = size_is_known ? bytes_for(options.point_count, false) : so_far;
  const Clock::time_point now = Clock::now();
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    reservation = reservation_;
    phases_.StartWaiting(now);
  }
  auto answer = [self = shared_from_this(), this](absl::Status status) { OnMemoryGranted(std::move(status)); };
  const absl::StatusOr<bool> granted = reservation->GrowTo(bytes, std::min(so_far, bytes), std::move(answer));
  if (granted.ok() && !*granted) return;
  {
    MutexLock lock(mutex_);
    if (granted.ok() && !receives_since_.has_value()) receives_since_ = now;
    granted.ok() ? phases_.EndWaiting(now) : phases_.ForgetWaiting();
  }
  if (!granted.ok()) return End(granted.status());
  ReadNext();
}

void EstimateCall::OnMemoryGranted(absl::Status status) {
  if (!status.ok()) return End(std::move(status));
  {
    MutexLock lock(mutex_);
    if (has_stopped_) return;
    if (!receives_since_.has_value()) receives_since_ = Clock::now();
    phases_.EndWaiting(Clock::now());
  }
  ReadNext();
}

void EstimateCall::ReceiveEnd() {
  if (absl::Status status = requests_.HalfClose(); !status.ok()) return End(std::move(status));
  account().record().normals_rescaled = requests_.normals_rescaled();
  account().record().coarse_positions = requests_.FindCoarsePositions();
  const CallOptions& options = requests_.options();
  account().record().least_neighbor_count = LeastNeighborCount(options);
  account().record().point_input = {options.has_normals(), options.has_viewpoints(), options.part.lattice.has_value(),
                                    options.scalar_type == ScalarType::kFloat64};
  {
    MutexLock lock(mutex_);
    receives_since_.reset();
    phases_.EndReceiving(Clock::now());
  }
  StartJob();
}

std::shared_ptr<EstimationJob> EstimateCall::MakeJob(EstimationJob::Callback done) {
  const CallOptions& options = requests_.options();
  const JobPriority priority = PriorityOf(options, requests_.points_received());
  NormalOptions normals = options.normals;
  if (options.has_viewpoints()) {
    viewpoints_ = requests_.TakeViewpoints();
    normals.sides = SidesTowardViewpoints{viewpoints_.span()};
  }
  directions_ = requests_.TakeDirections();
  if (!options.quantities.HasCurvature()) {
    return EstimationJob::StartNormals(requests_.TakeCloud(), normals, service().pool, priority, std::move(done),
                                       turn_key_);
  }
  return EstimationJob::Start(requests_.TakeCloud(), options.estimator, normals, service().pool, priority,
                              std::move(done), turn_key_);
}

void EstimateCall::StartJob() {
  EstimationJob::Callback done;
  const absl::Status made = CatchBadAlloc([&] {
    done = [self = shared_from_this(), this](JobResult result) { OnJobDone(std::move(result)); };
    return absl::OkStatus();
  });
  if (!made.ok()) return End(ExplainJobError(made));
  const std::shared_ptr<EstimationJob> job = MakeJob(std::move(done));
  bool cancel = false;
  std::optional<JobResult> early;
  {
    MutexLock lock(mutex_);
    cancel = has_stopped_;
    if (cancel) NoteJobSeconds(job->progress());
    job_ = job;
    early = std::move(early_result_);
  }
  if (cancel) job->Cancel();
  if (early.has_value()) OnJobDone(*std::move(early));
}

// A job may end before MakeJob returns it. Its result then waits for the job, which knows how long its phases took.
void EstimateCall::OnJobDone(JobResult result) {
  std::shared_ptr<EstimationJob> job;
  {
    MutexLock lock(mutex_);
    if (job_ == nullptr) {
      early_result_ = std::move(result);
      return;
    }
    job = std::move(job_);
    if (has_stopped_) return;
    if (!result.ok()) NoteJobSeconds(job->progress());
  }
  // A callback must not throw.
  const absl::Status sent = CatchBadAlloc([&] {
    result.ok() ? SendResults(*std::move(result)) : EndWithJobError(result.status(), job->progress());
    return absl::OkStatus();
  });
  if (!sent.ok()) End(ExplainJobError(sent));
}

void EstimateCall::EndWithJobError(const absl::Status& error, const JobProgress& job) {
  const bool came_to_curvature = job.seconds.estimate.has_value() ||
                                 !std::holds_alternative<NeighborRadius>(requests_.options().normals.neighborhood);
  End(ExplainJobError(error, came_to_curvature ? "header.options.radius" : "header.normals.radius"));
}

void EstimateCall::SendResults(EstimationResult result) {
  JudgeWrites();
  viewpoints_ = Viewpoints();
  const QuantitySet& quantities = requests_.options().quantities;
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  uint64_t points = 0;
  {
    MutexLock lock(mutex_);
    if (has_stopped_) return;
    results_ = {std::move(result.field.points),
                std::move(result.normals),
                std::move(result.choices),
                std::move(directions_),
                requests_.options().curvature_direction,
                std::move(result.smaller)};
    points = results_.size();
    CallRecord& record = account().record();
    record.status_counts = result.field.status_counts;
    record.agreement = result.agreement;
    record.off_surface = result.off_surface;
    record.normal_report = result.normal_report;
    record.scale_report = std::move(result.scale_report);
    record.peak_bytes = result.cost.peak_bytes;
    phases_.SetJobSeconds(result.cost.seconds);
    phases_.StartSending(Clock::now());
    responses_.Complete(points, ResultChunkPoints(quantities), 1 + results_.smaller.size());
    reservation = reservation_;
  }
  reservation->ShrinkTo(service().admission.SendingBytes(points, requests_.options()));
  WriteNext();
}

// What it throws would end the process on a thread of gRPC, or leave the stream writing for ever on a worker.
EstimateCall::Made EstimateCall::MakeMessage(grpc::ByteBuffer& message) {
  const absl::StatusOr<Made> made = CatchBadAlloc([&] { return PackNext(message); });
  if (made.ok()) return *made;
  End(ExplainJobError(made.status()));
  return Made::kNothing;
}

absl::StatusOr<EstimateCall::Made> EstimateCall::PackNext(grpc::ByteBuffer& message) {
  ResponseSession::Message next;
  {
    MutexLock lock(mutex_);
    next = responses_.Next();
  }
  if (next.kind == ResponseSession::Kind::kNothing) return Made::kNothing;
  if (next.kind == ResponseSession::Kind::kEnd) return Made::kLast;
  if (next.kind == ResponseSession::Kind::kResults) {
    const auto packed =
        PackResults(results_, next.first, next.count, requests_.options().quantities, ScaleOf(next.scale));
    if (!packed.ok()) return packed.status();
    grpc::ByteBuffer results(&*packed, 1);
    message.Swap(&results);
  } else {
    Response response;
    FillResponse(next.kind, response);
    Pack(response, message);
  }
  return Made::kMessage;
}

PackedScale EstimateCall::ScaleOf(uint64_t sent) const {
  const CallOptions& options = requests_.options();
  if (!options.names_counts) return {};
  // They are sent from small to large.
  const size_t scale = options.estimator.scale_count() - 1 - sent;
  return {scale == 0 ? nullptr : &results_.smaller[scale - 1],
          std::get<NeighborCount>(options.estimator.AtScale(scale).neighborhood).count};
}

void EstimateCall::FillResponse(ResponseSession::Kind kind, Response& response) {
  if (kind == ResponseSession::Kind::kAccepted) {
    FillAccepted(requests_.options(), limits_, account().request_id(), response.mutable_accepted());
  } else if (kind == ResponseSession::Kind::kProgress) {
    *response.mutable_progress() = CurrentProgress();
    MutexLock lock(mutex_);
    last_progress_ = response.progress();
  } else {
    FillSummary(response.mutable_summary());
  }
}

v1::Progress EstimateCall::CurrentProgress() {
  std::shared_ptr<EstimationJob> job;
  {
    MutexLock lock(mutex_);
    job = job_;
  }
  v1::Progress progress;
  FillProgress(points_received_.load(std::memory_order_relaxed),
               job == nullptr ? std::nullopt : std::optional<JobProgress>(job->progress()), &progress);
  return progress;
}

void EstimateCall::FillSummary(v1::Summary* summary) {
  CallRecord& record = account().record();
  {
    MutexLock lock(mutex_);
    phases_.EndSending(Clock::now());
    record.seconds = phases_.times();
  }
  curvd::FillSummary(record, summary);
}

bool EstimateCall::IsMissed() {
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    reservation = reservation_;
  }
  return reservation != nullptr && reservation->IsMissed();
}

void EstimateCall::OnTick(Clock::time_point now, bool is_writing) {
  const v1::Progress progress = CurrentProgress();
  {
    MutexLock lock(mutex_);
    const bool is_new = !last_progress_.has_value() || progress.phase() != last_progress_->phase() ||
                        progress.points_received() != last_progress_->points_received() ||
                        progress.points_estimated() != last_progress_->points_estimated();
    const bool is_due = !is_writing && (is_new || now - progress_due_at_ >= kProgressAtLeast);
    if (is_due) progress_due_at_ = now;
    responses_.SetProgressDue(is_due);
  }
  if (const auto reservation = ReservationOfSlowSender(now)) reservation->Lend();
}

std::shared_ptr<MemoryBudget::Reservation> EstimateCall::ReservationOfSlowSender(Clock::time_point now) {
  MutexLock lock(mutex_);
  if (!receives_since_.has_value() || now - *receives_since_ < kLendAfter) return nullptr;
  const uint64_t points = requests_.options().point_count, received = points_received_;
  if (points == 0 || received >= points) return nullptr;
  // At the pace so far, whatever it sent in between: a burst at the beginning does not buy much time.
  const auto rest = (now - *receives_since_) * (static_cast<double>(points - received) / std::max<double>(received, 1));
  return rest > kNeededSoon ? reservation_ : nullptr;
}

void EstimateCall::Stop() {
  std::shared_ptr<EstimationJob> job;
  std::shared_ptr<MemoryBudget::Reservation> reservation;
  {
    MutexLock lock(mutex_);
    has_stopped_ = true;
    job = job_;
    reservation = reservation_;
    if (job != nullptr) NoteJobSeconds(job->progress());
  }
  if (job != nullptr) job->Cancel();
  if (reservation != nullptr) reservation->Abandon();
}

void EstimateCall::CompleteRecord(CallRecord& record) {
  MutexLock lock(mutex_);
  phases_.End(Clock::now());
  record.seconds = phases_.times();
}

void EstimateCall::NoteJobSeconds(const JobProgress& job) { phases_.SetJobSeconds(job.seconds); }

}  // namespace curvd
