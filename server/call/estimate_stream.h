// One EstimateCurvature call on the server.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <chrono>
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
#include "server/admission/stream_gate.h"
#include "server/call/call_record.h"
#include "server/call/estimate_session.h"
#include "server/service_context.h"

namespace curvd {

// gRPC reports events on threads of its own, some at the same time. Three chains of events, each with one link at a
// time, share the call:
// - reading: StartRead, OnReadDone, perhaps a wait for memory, StartRead ...; after the half-close the job takes its
//   place. It appends the chunk to the cloud right in OnReadDone (a third of a millisecond for 1 MiB), while the bytes
//   are warm.
// - writing: Pump picks what is next, StartWrite, OnWriteDone, Pump ... It encodes a chunk of results (0.2 ms) right
//   before it is written: the first on the worker that finished the job, the others on gRPC's threads, and never more
//   than one, so that a slow reader costs one message of memory.
// - ending: whoever notices the end first (a bad message, the job, a cancel, a drain) sets the outcome; Pump sends it
//   once no write is in flight.
// Members belong to one chain each, or are guarded by the mutex. No call into gRPC is made with the mutex held, since
// gRPC may run the next event before it returns.
//
// The object lives until gRPC is done with it and nobody else (job, memory budget, gate) holds it.
//
// Messages are parsed here, from bytes: gRPC would report one that is no message as the end of the stream, and a cloud
// of unknown size would be estimated without the rest of its points.
class EstimateStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             public OpenStream,
                             public std::enable_shared_from_this<EstimateStream> {
 public:
  using Clock = std::chrono::steady_clock;

  // A reactor for a call that has just arrived. It owns itself. `service` must outlive it.
  static EstimateStream* Start(ServiceContext& service, grpc::CallbackServerContext& call);

  EstimateStream(ServiceContext& service, grpc::CallbackServerContext& call, const Caller& caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Tick(Clock::time_point now) override;
  void Abort(absl::Status status) override { End(std::move(status)); }

 private:
  static double SecondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  }

  enum class Write { kNone, kAccepted, kProgress, kResults, kSummary, kFinish };

  // Reading: estimate_stream_reading.cc.
  void ReadNext();
  void Receive();
  void OnHeaderAccepted();
  void ReserveThenRead();
  void OnMemoryGranted(absl::Status status);
  void OnHalfClose();
  void StartJob();
  void OnJobDone(absl::StatusOr<EstimationResult> result);

  // Writing: estimate_stream_writing.cc.
  void Pump();
  Write PickWrite() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void FillResponse(Write write);
  void FillProgress();
  void FillSummary();
  absl::Status PackNextResults();
  void SendPackedResponse();

  // Ending.
  // The status of a call whose caller has gone.
  absl::Status GoneStatus() const;
  // Sets the outcome, unless there is one, and stops what goes on.
  void End(absl::Status status);
  bool Stalls(Clock::time_point now) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void EndStalled();
  void ReleaseHold();
  // The wait for memory is over, unless none went on.
  void EndWait() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RecordJob(const JobProgress& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Ends the phase of which nobody has recorded the end. REQUIRES: the call is done.
  void RecordLastPhase() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  ServiceContext& service_;
  grpc::CallbackServerContext& call_;
  const CallLimits limits_;               // the caller's
  std::shared_ptr<EstimateStream> self_;  // until OnDone

  // Of the reading chain.
  grpc::ByteBuffer packed_request_;
  EstimateSession session_;
  Clock::time_point receive_started_;
  std::atomic<uint64_t> points_received_{0};  // may be read by anybody

  // Of the writing chain.
  grpc::ByteBuffer packed_response_;
  curvature::v1::EstimateCurvatureResponse response_;  // but results, which are packed as they are
  CurvatureField field_;
  uint64_t next_point_ = 0;
  Clock::time_point send_started_;

  // Each part of it belongs to the chain that measures it, all of it to OnDone.
  CallRecord record_;
  const Clock::time_point started_;
  const Clock::time_point deadline_;  // the caller's; on a clock that nobody sets

  Mutex mutex_;
  std::optional<absl::Status> outcome_ ABSL_GUARDED_BY(mutex_);
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool read_in_flight_ ABSL_GUARDED_BY(mutex_) = false;
  bool write_in_flight_ ABSL_GUARDED_BY(mutex_) = false;
  int holds_ ABSL_GUARDED_BY(mutex_) = 0;  // calls into gRPC that must return before Finish, which may end its objects
  bool finish_called_ ABSL_GUARDED_BY(mutex_) = false;
  Clock::time_point last_read_ ABSL_GUARDED_BY(mutex_);
  Clock::time_point last_write_ ABSL_GUARDED_BY(mutex_);
  bool accepted_due_ ABSL_GUARDED_BY(mutex_) = false;
  bool progress_due_ ABSL_GUARDED_BY(mutex_) = false;
  bool field_ready_ ABSL_GUARDED_BY(mutex_) = false;
  bool summary_written_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<Clock::time_point> waits_since_ ABSL_GUARDED_BY(mutex_);  // for memory
  std::shared_ptr<EstimationJob> job_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<MemoryBudget::Reservation> reservation_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
