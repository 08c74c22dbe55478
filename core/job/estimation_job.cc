#include "core/job/estimation_job.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <latch>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/out_of_memory.h"
#include "core/job/curvature_job.h"

namespace curvd {
namespace {

void Add(std::optional<double> seconds, std::optional<double>& sum) {
  if (seconds.has_value()) sum = sum.value_or(0.0) + *seconds;
}

void Add(const JobSeconds& seconds, JobSeconds& sum) {
  sum.queue += seconds.queue;
  Add(seconds.index, sum.index);
  Add(seconds.normals, sum.normals);
  Add(seconds.orientation, sum.orientation);
  Add(seconds.estimate, sum.estimate);
}

// Says what became of the points that are invalid in the cloud without outliers.
void MarkOutliers(const std::vector<int32_t>& outliers, EstimationResult& result) {
  for (const int32_t rank : outliers) {
    const auto slot = static_cast<size_t>(rank);
    result.field.points[slot].status = PointStatus::kOutlier;
    if (result.normals.size() > 0) result.normals[slot].status = PointStatus::kOutlier;
  }
  result.field.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)] -= outliers.size();
  result.field.status_counts[static_cast<size_t>(PointStatus::kOutlier)] += outliers.size();
}

// Runs one pass over the cloud, and another one without the outliers that the first has found, as long as passes find
// any. To its caller it is one job.
class RepeatedJob final : public EstimationJob, public std::enable_shared_from_this<RepeatedJob> {
 public:
  RepeatedJob(const std::array<double, 3>& origin, const std::optional<EstimatorOptions>& options,
              const NormalOptions& normals, const JobPlace& place)
      : origin_(origin), options_(options), normals_(normals), place_(place) {}

  // Makes a pass. May throw std::bad_alloc.
  void Prepare(Cloud cloud) {
    std::shared_ptr<CurvatureJob> next = MakePass(std::move(cloud));
    at_end_ = [self = shared_from_this()](auto result) { self->EndPass(std::move(result)); };
    MutexLock lock(mutex_);
    pass_ = std::move(next);
  }
  // From here on `callback` will be called, whatever happens.
  void Start(Callback callback) {
    callback_ = std::move(callback);
    StartPass();
  }

  void Cancel() override {
    is_cancelled_ = true;
    pass()->Cancel();
  }

  JobProgress progress() const override {
    std::shared_ptr<CurvatureJob> pass;
    JobSeconds seconds;
    size_t points = 0;
    {
      MutexLock lock(mutex_);
      pass = pass_;
      seconds = seconds_;
      points = points_estimated_;
    }
    JobProgress progress = pass->progress();
    Add(seconds, progress.seconds);
    progress.points_estimated = std::max(progress.points_estimated, points);
    // Between two passes one has ended, and the job has not. Normals alone are made in one pass.
    const bool may_pass_again = options_.has_value() && !is_done_;
    if (progress.phase == JobPhase::kDone && may_pass_again) progress.phase = JobPhase::kEstimating;
    return progress;
  }

 private:
  // Each takes as long as the first one.
  static constexpr int kMostPasses = 3;
  // A pass that has found so many, as a part of the points, has left others that lie nearer to the surface. Where there
  // are a few, they may be the points of a tip, and those beside it likewise.
  static constexpr size_t kManyInverse = 500;

  std::shared_ptr<CurvatureJob> pass() const {
    MutexLock lock(mutex_);
    return pass_;
  }

  std::shared_ptr<CurvatureJob> MakePass(Cloud cloud) {
    ++passes_;
    const bool has_many = outliers_.size() * kManyInverse >= cloud.size() && !outliers_.empty();
    const OutlierSearch search = passes_ == kMostPasses ? OutlierSearch::kNone
                                 : has_many             ? OutlierSearch::kAgain
                                                        : OutlierSearch::kFirst;
    return CurvatureJob::Make(std::move(cloud), origin_, options_, normals_, place_, search);
  }

  void StartPass() {
    const std::shared_ptr<CurvatureJob> pass = this->pass();
    pass->Start(std::exchange(at_end_, nullptr));
    // Cancel may have come to the pass before.
    if (is_cancelled_) pass->Cancel();
  }

  void EndPass(absl::StatusOr<EstimationResult> result) {
    const std::shared_ptr<CurvatureJob> ended = pass();
    std::optional<OutlierPhases::Rest> rest = ended->TakeRest();
    if (!result.ok() || !rest.has_value()) return End(std::move(result));
    const absl::Status status = CatchBadAlloc([&] {
      AddCost(result->cost);
      outliers_.insert(outliers_.end(), rest->outliers.begin(), rest->outliers.end());
      {
        MutexLock lock(mutex_);
        Add(result->cost.seconds, seconds_);
        points_estimated_ = std::max(points_estimated_, ended->progress().points_estimated);
      }
      Prepare(std::move(rest->cloud));
      return absl::OkStatus();
    });
    status.ok() ? StartPass() : End(status);
  }

  void AddCost(const JobCost& cost) {
    cost_.phases.insert(cost_.phases.end(), cost.phases.begin(), cost.phases.end());
    cost_.peak_bytes = std::max(cost_.peak_bytes, cost.peak_bytes);
    Add(cost.seconds, cost_.seconds);
  }

  void End(absl::StatusOr<EstimationResult> result) {
    if (result.ok() && passes_ > 1) {
      MarkOutliers(outliers_, *result);
      const absl::Status status = CatchBadAlloc([&] {
        AddCost(result->cost);
        return absl::OkStatus();
      });
      if (status.ok()) {
        result->cost = std::move(cost_);
      } else {
        result = status;
      }
    }
    is_done_ = true;
    std::exchange(callback_, nullptr)(std::move(result));
  }

  const std::array<double, 3> origin_;
  const std::optional<EstimatorOptions> options_;
  const NormalOptions normals_;
  const JobPlace place_;
  Callback callback_;
  Callback at_end_;  // of the pass that has not begun
  // Of the passes that have ended; nobody reads them meanwhile.
  int passes_ = 0;
  std::vector<int32_t> outliers_;
  JobCost cost_;

  std::atomic<bool> is_cancelled_ = false;
  std::atomic<bool> is_done_ = false;
  mutable Mutex mutex_;
  std::shared_ptr<CurvatureJob> pass_ ABSL_GUARDED_BY(mutex_);
  JobSeconds seconds_ ABSL_GUARDED_BY(mutex_);  // of the passes before
  size_t points_estimated_ ABSL_GUARDED_BY(mutex_) = 0;
};

// Stands for a job that could not be made: it has ended.
class EndedJob final : public EstimationJob {
 public:
  void Cancel() override {}
  JobProgress progress() const override { return {.phase = JobPhase::kDone, .seconds = {}}; }
};

}  // namespace

std::shared_ptr<EstimationJob> EstimationJob::Start(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool,
                                                    JobPriority priority, Callback callback, CallerKey caller) {
  return Start(std::move(cloud), options, NormalOptions(), pool, priority, std::move(callback), caller);
}

namespace {

std::shared_ptr<EstimationJob> StartJob(Cloud cloud, const std::optional<EstimatorOptions>& options,
                                        const NormalOptions& normals, WorkerPool& pool, JobPriority priority,
                                        EstimationJob::Callback callback, CallerKey caller) {
  std::shared_ptr<RepeatedJob> job;
  absl::Status status = CatchBadAlloc([&] {
    job = std::make_shared<RepeatedJob>(cloud.origin(), options, normals, JobPlace{pool, priority, caller});
    job->Prepare(std::move(cloud));
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

}  // namespace

std::shared_ptr<EstimationJob> EstimationJob::Start(Cloud cloud, const EstimatorOptions& options,
                                                    const NormalOptions& normals, WorkerPool& pool,
                                                    JobPriority priority, Callback callback, CallerKey caller) {
  return StartJob(std::move(cloud), options, normals, pool, priority, std::move(callback), caller);
}

std::shared_ptr<EstimationJob> EstimationJob::StartNormals(Cloud cloud, const NormalOptions& normals, WorkerPool& pool,
                                                           JobPriority priority, Callback callback, CallerKey caller) {
  return StartJob(std::move(cloud), std::nullopt, normals, pool, priority, std::move(callback), caller);
}

absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool) {
  return EstimateCurvature(std::move(cloud), options, NormalOptions(), pool);
}

absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options,
                                                   const NormalOptions& normals, WorkerPool& pool) {
  absl::StatusOr<EstimationResult> result;
  std::latch done(1);
  EstimationJob::Start(std::move(cloud), options, normals, pool, JobPriority::kBatch, [&](auto estimated) {
    result = std::move(estimated);
    done.count_down();
  });
  done.wait();
  return result;
}

}  // namespace curvd
