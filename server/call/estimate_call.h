// One EstimateCurvature call on the server.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/job/estimation_job.h"
#include "curvature/v1/curvature.pb.h"
#include "server/admission/memory_budget.h"
#include "server/call/chunk/directions.h"
#include "server/call/chunk/viewpoints.h"
#include "server/call/phase_clock.h"
#include "server/call/request_limits.h"
#include "server/call/request_session.h"
#include "server/call/response_session.h"
#include "server/call/result_encoder.h"
#include "server/rpc/bidi_stream.h"

namespace curvd {

// Joins the two sessions of a call to its memory and its job:
// - The reading chain gives each message to the RequestSession, which appends a chunk's points to the cloud right there
//   (a third of a millisecond for 1 MiB), while the bytes are warm, and reserves memory before it reads on. After the
//   half-close the job takes the chain's place.
// - The writing chain asks the ResponseSession what comes next, and packs it (0.2 ms for a chunk of results): the first
//   chunk on the worker that finished the job, the others on gRPC's threads.
//
// Members belong to one chain each, or are guarded by the mutex, which is held in no call to BidiStream, job or memory.
// Beside gRPC, the job and the memory budget hold the object, until they have called back.
class EstimateCall final : public BidiStream {
 public:
  EstimateCall(ServiceContext& service, const RpcArrival& arrival, BidiTransport& transport);

 private:
  using JobResult = absl::StatusOr<EstimationResult>;

  // The reading chain.
  void Receive(grpc::ByteBuffer& message) override;
  void ReceiveEnd() override;
  void AcceptHeader();
  void ReserveThenRead();
  void OnMemoryGranted(absl::Status status);
  void StartJob();
  // Hands the cloud to a job of its kind.
  std::shared_ptr<EstimationJob> MakeJob(EstimationJob::Callback done);
  void OnJobDone(JobResult result);
  void EndWithJobError(const absl::Status& error, const JobProgress& job);
  void SendResults(EstimationResult result);

  // The writing chain.
  Made MakeMessage(grpc::ByteBuffer& message) override;
  absl::StatusOr<Made> PackNext(grpc::ByteBuffer& message);
  // The scale of results of which so many scales were sent before.
  PackedScale ScaleOf(uint64_t sent) const;
  // All but results, which are packed as they are.
  void FillResponse(ResponseSession::Kind kind, curvature::v1::EstimateCurvatureResponse& response);
  curvature::v1::Progress CurrentProgress();
  void FillSummary(curvature::v1::Summary* summary);

  // The end, and what happens beside the chains.
  bool IsMissed() override;
  void OnTick(Clock::time_point now, bool is_writing) override;
  void Stop() override;
  void CompleteRecord(CallRecord& record) override;
  // The reservation, if the rest of the cloud comes so slowly that its memory is not needed soon; else null.
  std::shared_ptr<MemoryBudget::Reservation> ReservationOfSlowSender(Clock::time_point now);
  void NoteJobSeconds(const JobProgress& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const CallLimits limits_;  // the caller's
  const uint64_t turn_key_;  // the caller's

  RequestSession requests_;                   // of the reading chain
  std::atomic<uint64_t> points_received_{0};  // written by the reading chain

  Viewpoints viewpoints_;  // of the cloud that the job has
  Directions directions_;  // likewise, until its results are complete
  CallResults results_;    // set before the responses are complete, then of the writing chain

  Mutex mutex_;
  bool has_stopped_ ABSL_GUARDED_BY(mutex_) = false;
  ResponseSession responses_ ABSL_GUARDED_BY(mutex_);
  std::optional<curvature::v1::Progress> last_progress_ ABSL_GUARDED_BY(mutex_);  // that was sent
  Clock::time_point progress_due_at_ ABSL_GUARDED_BY(mutex_){};                   // the last
  PhaseClock phases_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<EstimationJob> job_ ABSL_GUARDED_BY(mutex_);     // while it runs
  std::optional<JobResult> early_result_ ABSL_GUARDED_BY(mutex_);  // of a job that ended before job_ was set
  std::shared_ptr<MemoryBudget::Reservation> reservation_ ABSL_GUARDED_BY(mutex_);
  // Since its memory was granted, until the half-close.
  std::optional<Clock::time_point> receives_since_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
