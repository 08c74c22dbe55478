#include "client/estimate_attempt.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/result_collector.h"
#include "client/rpc_error.h"
#include "grpcpp/client_context.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
using Phase = EstimateProgress::Phase;

v1::Estimator ToProto(Estimator estimator) {
  switch (estimator) {
    case Estimator::kAvgHexagram:
      return v1::ESTIMATOR_AVG_HEXAGRAM;
    case Estimator::kHexagram:
      return v1::ESTIMATOR_HEXAGRAM;
    case Estimator::kUniform:
      return v1::ESTIMATOR_UNIFORM;
    case Estimator::kIndependent:
      return v1::ESTIMATOR_INDEPENDENT;
    case Estimator::kDelaunay:
      return v1::ESTIMATOR_DELAUNAY;
    case Estimator::kJetFitting:
      return v1::ESTIMATOR_JET_FITTING;
    case Estimator::kAlgebraicShapeOperator:
      return v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR;
  }
  return v1::ESTIMATOR_UNSPECIFIED;
}

v1::Priority ToProto(Priority priority) {
  switch (priority) {
    case Priority::kBySize:
      return v1::PRIORITY_UNSPECIFIED;
    case Priority::kInteractive:
      return v1::PRIORITY_INTERACTIVE;
    case Priority::kBatch:
      return v1::PRIORITY_BATCH;
  }
  return v1::PRIORITY_UNSPECIFIED;
}

v1::EstimateCurvatureRequest MakeHeader(const CloudView& cloud, const EstimateOptions& options) {
  v1::EstimateCurvatureRequest request;
  v1::CloudHeader& header = *request.mutable_header();
  header.set_point_count(cloud.size());
  header.set_scalar_type(cloud.is_double() ? v1::SCALAR_TYPE_FLOAT64 : v1::SCALAR_TYPE_FLOAT32);
  header.mutable_origin()->set_x(options.origin[0]);
  header.mutable_origin()->set_y(options.origin[1]);
  header.mutable_origin()->set_z(options.origin[2]);
  v1::EstimatorOptions& estimator = *header.mutable_options();
  estimator.set_estimator(ToProto(options.estimator));
  if (options.radius) {
    estimator.set_radius(*options.radius);
  } else {
    estimator.set_neighbor_count(options.neighbor_count);
  }
  estimator.set_triangle_count(options.triangle_count);
  estimator.set_rotation_count(options.rotation_count);
  estimator.set_jet_degree(options.jet_degree);
  estimator.set_even_weights(options.even_weights);
  estimator.set_seed(options.seed);
  if (options.average_normal_weight) estimator.set_average_normal_weight(*options.average_normal_weight);
  header.set_invalid_point_policy(options.skip_invalid ? v1::INVALID_POINT_POLICY_SKIP
                                                       : v1::INVALID_POINT_POLICY_REJECT);
  header.set_request_tag(options.request_tag);
  header.set_priority(ToProto(options.priority));
  return request;
}

Phase PhaseOf(const v1::Progress& progress) {
  switch (progress.phase()) {
    case v1::Progress::PHASE_QUEUED:
      return Phase::kQueued;
    case v1::Progress::PHASE_INDEXING:
      return Phase::kIndexing;
    case v1::Progress::PHASE_ESTIMATING:
      return Phase::kEstimating;
    case v1::Progress::PHASE_SENDING:
      return Phase::kReceiving;
    default:
      return Phase::kSending;
  }
}

class Attempt {
 public:
  Attempt(const CloudView& cloud, const EstimateOptions& options, const EstimateCallbacks& callbacks, int attempt)
      : cloud_(cloud), options_(options), callbacks_(callbacks), collector_(cloud.size()) {
    progress_.points = cloud.size();
    progress_.attempt = attempt;
  }

  AttemptOutcome Run(v1::CurvatureService::Stub& stub, absl::Duration timeout) {
    if (timeout != absl::InfiniteDuration()) context_.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
    const std::stop_callback cancel(callbacks_.stop, [this] { context_.TryCancel(); });
    Report([](EstimateProgress&) {});
    stream_ = stub.EstimateCurvature(&context_);
    std::thread reader([this] { Read(); });
    Write();
    reader.join();
    const grpc::Status status = stream_->Finish();
    return Conclude(status);
  }

 private:
  // The thread that reads: until the stream ends, or breaks the protocol.
  void Read() {
    v1::EstimateCurvatureResponse response;
    while (stream_->Read(&response)) {
      broken_ = Take(response);
      if (!broken_.ok()) {
        context_.TryCancel();
        break;
      }
      if (response.has_accepted()) SetAnswer(collector_.limits().max_chunk_bytes());
      Report([this](EstimateProgress& progress) {
        progress.points_received = collector_.points_received();
        progress.points_estimated = collector_.progress().points_estimated();
        const Phase phase = progress.points_received > 0 ? Phase::kReceiving : PhaseOf(collector_.progress());
        progress.phase = std::max(progress.phase, phase);
      });
    }
    // The writer may still wait to be accepted.
    SetAnswer(0);
    // Lets a writer go that is blocked on a stream that nobody reads.
    while (stream_->Read(&response)) {
    }
  }

  absl::Status Take(const v1::EstimateCurvatureResponse& response) {
    try {
      return collector_.Take(response);
    } catch (const std::bad_alloc&) {
      return absl::ResourceExhaustedError(absl::StrCat("no memory for the results of ", cloud_.size(), " points"));
    }
  }

  void Write() {
    if (!stream_->Write(MakeHeader(cloud_, options_))) return;
    const uint64_t allowed = WaitForAnswer();
    if (allowed > 0) WriteChunks(std::min<uint64_t>(allowed, options_.chunk_bytes));
    stream_->WritesDone();
  }

  void WriteChunks(uint64_t chunk_bytes) {
    const size_t point_bytes = cloud_.point_bytes();
    const size_t chunk_points = std::max<size_t>(1, chunk_bytes / (2 * point_bytes));
    v1::EstimateCurvatureRequest request;
    for (size_t first = 0; first < cloud_.size(); first += chunk_points) {
      const size_t count = std::min(chunk_points, cloud_.size() - first);
      v1::PointChunk& chunk = *request.mutable_chunk();
      chunk.set_first_index(first);
      chunk.set_positions(cloud_.positions().data() + first * point_bytes, count * point_bytes);
      chunk.set_normals(cloud_.normals().data() + first * point_bytes, count * point_bytes);
      if (!stream_->Write(request)) return;  // the stream has ended; Finish tells why
      Report([&](EstimateProgress& progress) {
        progress.phase = std::max(progress.phase, Phase::kSending);
        progress.points_sent = first + count;
      });
    }
  }

  // Bytes that a chunk may hold; 0: the stream ended without an answer.
  void SetAnswer(uint64_t max_chunk_bytes) {
    const std::lock_guard lock(mutex_);
    if (max_chunk_bytes_) return;
    max_chunk_bytes_ = max_chunk_bytes;
    answered_.notify_one();
  }

  uint64_t WaitForAnswer() {
    std::unique_lock lock(mutex_);
    answered_.wait(lock, [this] { return max_chunk_bytes_.has_value(); });
    return *max_chunk_bytes_;
  }

  template <typename Change>
  void Report(const Change& change) {
    const std::lock_guard lock(mutex_);
    change(progress_);
    if (callbacks_.on_progress) callbacks_.on_progress(progress_);
  }

  AttemptOutcome Conclude(const grpc::Status& status) {
    if (!broken_.ok()) return {std::nullopt, {broken_, std::nullopt}};
    if (!status.ok()) return {std::nullopt, {ToAbslStatus(status), RetryDelay(status)}};
    if (absl::Status finish = collector_.Finish(); !finish.ok()) return {std::nullopt, {finish, std::nullopt}};
    return {collector_.Release(), {}};
  }

  const CloudView& cloud_;
  const EstimateOptions& options_;
  const EstimateCallbacks& callbacks_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::EstimateCurvatureRequest, v1::EstimateCurvatureResponse>> stream_;
  // The reader's until it is joined.
  ResultCollector collector_;
  absl::Status broken_;

  std::mutex mutex_;
  std::condition_variable answered_;         // max_chunk_bytes_ has a value
  std::optional<uint64_t> max_chunk_bytes_;  // guarded by mutex_
  EstimateProgress progress_;                // guarded by mutex_
};

}  // namespace

AttemptOutcome RunAttempt(v1::CurvatureService::Stub& stub, const CloudView& cloud, const EstimateOptions& options,
                          absl::Duration timeout, int attempt, const EstimateCallbacks& callbacks) {
  return Attempt(cloud, options, callbacks, attempt).Run(stub, timeout);
}

}  // namespace curv
