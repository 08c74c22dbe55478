// The writing chain of EstimateStream: from Accepted to the status.
#include <grpc/support/log.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <algorithm>
#include <utility>

#include "server/call/call_errors.h"
#include "server/call/call_summary.h"
#include "server/call/estimate_stream.h"
#include "server/call/result_encoder.h"
#include "server/call/rpc_status.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using Response = v1::EstimateCurvatureResponse;

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
      last_write_ = Clock::now();
    }
  }
  if (write == Write::kFinish) {
    service_.gate.FreePlace(this);
    Finish(ToGrpcStatus(outcome, record_.request_id));
  } else {
    if (write == Write::kResults) {
      if (absl::Status status = PackNextResults(); !status.ok()) {
        {
          MutexLock lock(mutex_);
          write_in_flight_ = false;
        }
        return End(ExplainJobError(std::move(status)));
      }
    } else {
      FillResponse(write);
      packed_response_.Clear();
      bool own_buffer = false;
      GPR_ASSERT(grpc::SerializationTraits<Response>::Serialize(response_, &packed_response_, &own_buffer).ok());
    }
    SendPackedResponse();
  }
}

void EstimateStream::SendPackedResponse() {
  const uint64_t bytes = packed_response_.Length();
  ++record_.messages_sent;
  record_.bytes_sent += bytes;
  service_.metrics.CountSent(RpcMethod::kEstimateCurvature, bytes);
  {
    MutexLock lock(mutex_);
    last_write_ = Clock::now();
  }
  StartWrite(&packed_response_);
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
      return FillAccepted(session_.options(), limits_, record_.request_id, response_.mutable_accepted());
    case Write::kProgress:
      return FillProgress();
    case Write::kSummary:
      return FillSummary();
    case Write::kResults:
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

absl::Status EstimateStream::PackNextResults() {
  const uint64_t count = std::min<uint64_t>(kResultChunkPoints, field_.points.size() - next_point_);
  const auto message = PackResults(field_.points, next_point_, count, session_.options().quantities);
  if (!message.ok()) return message.status();
  grpc::ByteBuffer packed(&*message, 1);
  packed_response_.Swap(&packed);
  next_point_ += count;
  return absl::OkStatus();
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
    End(GoneStatus());
  }
}

}  // namespace curvd
