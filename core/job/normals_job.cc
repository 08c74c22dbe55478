#include "core/job/normals_job.h"

#include <latch>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/out_of_memory.h"
#include "core/index/index_builder.h"
#include "core/job/index_phases.h"
#include "core/job/normal_phases.h"
#include "core/job/phased_job.h"

namespace curvd {
namespace {

NormalOptions Returning(NormalOptions options) {
  options.returns_normals = true;
  return options;
}

class IndexedNormalsJob final : public NormalsJob, public PhasedJob {
 public:
  IndexedNormalsJob(Cloud cloud, const NormalOptions& options, WorkerPool& pool, JobPriority priority, CallerKey caller)
      : PhasedJob(pool, priority, caller),
        options_(Returning(options)),
        size_(cloud.size()),
        invalid_count_(cloud.invalid_query_count()),
        origin_(cloud.origin()),
        builder_(std::in_place, std::move(cloud), StopSign(&stopped())) {}

  // From here on `callback` will be called, whatever happens.
  void Start(Callback callback) {
    callback_ = std::move(callback);
    Run(CatchBadAlloc([this] {
      AddPhase(std::make_unique<EdgePhase>([this] { return Begin(); }));
      AddPhase(MakeCollectPhase(*builder_));
      AddPhase(MakeCollectPhase(*builder_));
      AddPhase(MakeTreePhase(*builder_));
      AddPhase(std::make_unique<EdgePhase>([this] { return AddNormals(); }));
      return absl::OkStatus();
    }));
  }

  void Cancel() override { PhasedJob::Cancel(); }

 private:
  // Runs a function between other phases of the index.
  class EdgePhase final : public Phase {
   public:
    explicit EdgePhase(std::function<absl::Status()> run) : run_(std::move(run)) {}
    std::string_view name() const override { return kIndexPhase; }
    absl::StatusOr<size_t> Begin() override { return 0; }
    absl::Status RunBlock(const BlockContext& /*context*/) override { return absl::OkStatus(); }
    absl::Status End() override { return run_(); }

   private:
    const std::function<absl::Status()> run_;
  };

  absl::Status Begin() {
    absl::Status status = options_.Validate(size_);
    return status.ok() ? builder_->Start() : status;
  }

  absl::Status AddNormals() {
    index_ = builder_->Take();
    builder_.reset();
    if (options_.source != NormalSource::kEstimate && !index_.has_normals()) {
      return MakeCoreError(ErrorKind::kInvalid, "the cloud has no normals; ask for estimated ones");
    }
    phases_.emplace(
        options_, origin_, index_, pool().thread_count(), [this](auto phase) { AddPhase(std::move(phase)); },
        [this] { return phases_->AddCollection(normals_, [] { return absl::OkStatus(); }); });
    if (options_.source != NormalSource::kGiven) return phases_->Start();
    return phases_->AddCollection(normals_, [] { return absl::OkStatus(); });
  }

  size_t HeldBytes() const override {
    const size_t building = builder_.has_value() ? builder_->bytes() : 0;
    return building + index_.bytes() + normals_.bytes() + (phases_.has_value() ? phases_->bytes() : 0);
  }

  void OnEnd(absl::Status status) override {
    Callback callback = std::move(callback_);
    absl::StatusOr<NormalResult> result = CatchBadAlloc([&]() -> absl::StatusOr<NormalResult> {
      if (!status.ok()) return std::move(status);
      NormalReport report = phases_->report();
      report.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)] += invalid_count_;
      return NormalResult{std::move(normals_), report, Cost()};
    });
    // Gone before the callback: what it needs memory for may be an error that says that there was none.
    phases_.reset();
    builder_.reset();
    index_ = SpatialIndex();
    if (!result.ok()) normals_ = {};
    callback(std::move(result));
  }

  JobCost Cost() const {
    JobCost cost;
    cost.phases = phase_times();
    cost.queue_seconds = SecondsOf(cost.phases, kQueuePhase);
    cost.index_seconds = SecondsOf(cost.phases, kIndexPhase);
    for (const PhaseTime& phase : cost.phases) {
      if (phase.name != kQueuePhase && phase.name != kIndexPhase) cost.estimate_seconds += phase.seconds;
    }
    cost.peak_bytes = peak_bytes();
    return cost;
  }

  const NormalOptions options_;
  Callback callback_;
  const size_t size_;
  const size_t invalid_count_;
  const std::array<double, 3> origin_;
  std::optional<IndexBuilder> builder_;
  SpatialIndex index_;
  NormalField normals_;
  std::optional<NormalPhases> phases_;
};

// Stands for a job that could not be made: it has ended.
class EndedJob final : public NormalsJob {
 public:
  void Cancel() override {}
};

}  // namespace

std::shared_ptr<NormalsJob> NormalsJob::Start(Cloud cloud, const NormalOptions& options, WorkerPool& pool,
                                              JobPriority priority, Callback callback, CallerKey caller) {
  std::shared_ptr<IndexedNormalsJob> job;
  absl::Status status = CatchBadAlloc([&] {
    job = std::make_shared<IndexedNormalsJob>(std::move(cloud), options, pool, priority, caller);
    return absl::OkStatus();
  });
  if (!status.ok()) {
    callback(std::move(status));
    static EndedJob ended;
    return {std::shared_ptr<void>(), &ended};  // owns nothing, and allocates nothing
  }
  job->Start(std::move(callback));
  return job;
}

absl::StatusOr<NormalResult> MakeNormals(Cloud cloud, const NormalOptions& options, WorkerPool& pool) {
  absl::StatusOr<NormalResult> result;
  std::latch done(1);
  NormalsJob::Start(std::move(cloud), options, pool, JobPriority::kBatch, [&](auto made) {
    result = std::move(made);
    done.count_down();
  });
  done.wait();
  return result;
}

}  // namespace curvd
