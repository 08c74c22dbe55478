#include "core/job/estimation_job.h"

#include <algorithm>
#include <chrono>
#include <latch>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/group_estimator.h"
#include "core/index/index_builder.h"
#include "core/index/spatial_index.h"

namespace curvd {
namespace {

// At most about 1,000 points a block, which take under a millisecond at K = 50; fewer where a point costs more, since
// others wait for the end of a block.
constexpr size_t kGroupsPerBlock = 16;
constexpr size_t kNeighborsPerBlock = kGroupsPerBlock * 64;  // neighbors of one point, times groups
constexpr size_t kGroupsPerRadiusBlock = 4;                  // nobody knows how many neighbors there will be
constexpr size_t kFillPoints = 100'000;  // a few milliseconds, most of them for the system's fresh pages

size_t GroupsPerBlock(const EstimationPlan& plan) {
  if (plan.by_radius) return kGroupsPerRadiusBlock;
  return std::clamp<size_t>(kNeighborsPerBlock / std::max<size_t>(plan.searched_count, 1), 1, kGroupsPerBlock);
}

// The job as a chain of phases on the pool; each phase's end starts the next. Kept alive by the functions that the pool
// holds.
class PhasedJob final : public EstimationJob, public std::enable_shared_from_this<PhasedJob> {
 public:
  PhasedJob(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool, JobPriority priority, CallerKey caller,
            Callback callback)
      : cloud_(std::move(cloud)),
        options_(options),
        pool_(pool),
        priority_(priority),
        caller_(caller),
        callback_(std::move(callback)),
        started_(Clock::now()) {}

  void Start() {
    if (absl::Status status = options_.Validate(); !status.ok()) return callback_(status);
    point_count_ = cloud_.size();
    invalid_count_ = cloud_.invalid_count();
    builder_.emplace(std::move(cloud_), &cancelled_);
    if (absl::Status status = builder_->Start(); !status.ok()) return callback_(status);
    RunIndexPhase();
  }

  void Cancel() override { cancelled_ = true; }

  JobProgress progress() const override {
    JobProgress progress{phase_, estimated_, 0.0, {}, {}};
    const double indexing = indexing_since_, estimating = estimating_since_;
    double end = ended_after_;
    if (end == kNotYet) end = SecondsSinceStart();
    progress.queue_seconds = indexing == kNotYet ? end : indexing;
    if (indexing != kNotYet) progress.index_seconds = (estimating == kNotYet ? end : estimating) - indexing;
    if (estimating != kNotYet) progress.estimate_seconds = end - estimating;
    return progress;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kNotYet = -1.0;

  void MarkStarted() {
    JobPhase queued = JobPhase::kQueued;
    if (phase_.compare_exchange_strong(queued, JobPhase::kIndexing)) indexing_since_ = SecondsSinceStart();
  }

  void RunIndexPhase() {
    if (builder_->block_count() == 0) return SubmitPart(builder_->root());
    pool_.Submit(
        priority_, builder_->block_count(),
        [self = shared_from_this()](size_t block, int) {
          self->MarkStarted();
          if (!self->cancelled_) self->builder_->RunBlock(block);
        },
        [self = shared_from_this()] { self->EndIndexPhase(); }, &cancelled_, caller_);
  }

  void EndIndexPhase() {
    if (cancelled_) return Finish(IndexCancelled());
    builder_->EndPhase();
    RunIndexPhase();
  }

  // No part waits for another: whoever splits one submits its halves.
  void SubmitPart(const IndexBuilder::Part& part) {
    ++open_parts_;
    pool_.Submit(
        priority_, 1,
        [self = shared_from_this(), part](size_t, int) {
          self->MarkStarted();
          self->builder_->Build(part, [&](const IndexBuilder::Part& half) { self->SubmitPart(half); });
        },
        [self = shared_from_this()] {
          if (--self->open_parts_ == 0) self->EndTree();
        },
        &cancelled_, caller_);
  }

  void EndTree() { cancelled_ ? Finish(IndexCancelled()) : StartEstimation(); }

  static absl::Status IndexCancelled() { return absl::CancelledError("cancelled while the index was built"); }

  void StartEstimation() {
    index_ = builder_->Take();
    const size_t cloud_bytes = builder_->cloud_bytes();
    builder_.reset();  // the index holds all that is needed
    auto points = PageArray<PointCurvature>::Create(point_count_);
    if (!points.ok()) return Finish(points.status());
    field_.points = *std::move(points);
    cost_.peak_bytes = index_.bytes() + std::max(cloud_bytes, field_.points.bytes());
    plan_ = EstimationPlan::Make(options_, index_);
    groups_per_block_ = GroupsPerBlock(plan_);
    estimating_since_ = SecondsSinceStart();
    phase_ = JobPhase::kEstimating;
    field_.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)] = invalid_count_;
    // Points that the index holds are written again.
    invalid_count_ > 0 ? FillInvalid() : EstimateField();
  }

  void FillInvalid() {
    pool_.Submit(
        priority_, (point_count_ + kFillPoints - 1) / kFillPoints,
        [self = shared_from_this()](size_t block, int) {
          if (!self->cancelled_) self->Fill(block * kFillPoints, PointStatus::kInvalidInput);
        },
        [self = shared_from_this()] { self->EstimateField(); }, &cancelled_, caller_);
  }

  void EstimateField() {
    if (cancelled_) return Finish(absl::CancelledError("cancelled before curvature was estimated"));
    if (!plan_.by_radius && index_.point_count() < plan_.neighbor_count) {
      FillIndexed(PointStatus::kTooFewNeighbors);
      field_.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)] = index_.point_count();
      return FinishField();
    }
    if (index_.point_count() == 0) return FinishField();
    scratch_.resize(pool_.thread_count());
    options_.estimator == EstimatorKind::kDelaunay ? BuildRims() : EstimateBlocks();
  }

  // Submits `run` for each block of groups, and `done` after them.
  void SubmitBlocks(void (PhasedJob::*run)(size_t block, int worker), void (PhasedJob::*done)()) {
    pool_.Submit(
        priority_, (index_.group_count() + groups_per_block_ - 1) / groups_per_block_,
        [self = shared_from_this(), run](size_t block, int worker) { ((*self).*run)(block, worker); },
        [self = shared_from_this(), done] { ((*self).*done)(); }, &cancelled_, caller_);
  }

  size_t BlockPoints() const { return groups_per_block_ * SpatialIndex::kGroupPoints; }
  size_t EndGroup(size_t block) const { return std::min((block + 1) * groups_per_block_, index_.group_count()); }

  void BuildRims() {
    auto umbrellas = PageArray<Umbrella>::Create(index_.leaf_count() * SpatialIndex::kLeafSize);
    if (!umbrellas.ok()) return Finish(umbrellas.status());
    umbrellas_ = *std::move(umbrellas);
    umbrella_plan_ = EstimationPlan::ForUmbrellas(index_);
    plan_.umbrellas = umbrellas_.data();
    cost_.peak_bytes += umbrellas_.bytes();
    SubmitBlocks(&PhasedJob::BuildRimBlock, &PhasedJob::EndRims);
  }

  void BuildRimBlock(size_t block, int worker) {
    for (size_t group = block * groups_per_block_; group < EndGroup(block) && !cancelled_; ++group) {
      BuildUmbrellas(index_, umbrella_plan_, group, scratch_[worker], umbrellas_.data());
    }
  }

  void EndRims() {
    if (cancelled_) return Finish(UmbrellasCancelled());
    SubmitBlocks(&PhasedJob::CountOccurrenceBlock, &PhasedJob::EndUmbrellas);
  }

  void CountOccurrenceBlock(size_t block, int) {
    if (cancelled_) return;
    const size_t last = std::min(EndGroup(block) * SpatialIndex::kGroupPoints, index_.point_count());
    CountOccurrences(umbrellas_.data(), block * BlockPoints(), last);
  }

  void EndUmbrellas() {
    if (cancelled_) return Finish(UmbrellasCancelled());
    cost_.umbrella_seconds = SecondsSinceStart() - estimating_since_;
    EstimateBlocks();
  }

  static absl::Status UmbrellasCancelled() { return absl::CancelledError("cancelled while umbrellas were built"); }

  void EstimateBlocks() { SubmitBlocks(&PhasedJob::EstimateBlock, &PhasedJob::EndEstimation); }

  void EstimateBlock(size_t block, int worker) {
    for (size_t group = block * groups_per_block_; group < EndGroup(block); ++group) {
      if (cancelled_ || oversized_point_ >= 0) return;
      const OversizedNeighborhood oversized =
          EstimateGroup(index_, plan_, group, scratch_[worker], field_.points.data());
      if (oversized.point_id >= 0) oversized_point_ = oversized.point_id;
    }
    estimated_ += std::min(BlockPoints(), index_.point_count() - block * BlockPoints());
  }

  void EndEstimation() {
    if (cancelled_) return Finish(absl::CancelledError("cancelled while curvature was estimated"));
    if (oversized_point_ >= 0) {
      return Finish(absl::ResourceExhaustedError(absl::StrFormat(
          "radius %g gives point %d more than %u neighbors, the limit of this server; use a smaller radius, or "
          "neighbor_count",
          plan_.radius, oversized_point_.load(), options_.max_neighbor_count)));
    }
    FinishField();
  }

  // Fills kFillPoints points from `first` on, or up to the last.
  void Fill(size_t first, PointStatus status) {
    const size_t last = std::min(first + kFillPoints, field_.points.size());
    std::fill(&field_.points[first], field_.points.data() + last, WithRadius(UndefinedCurvature(status)));
  }

  void FillIndexed(PointStatus status) {
    for (size_t leaf = 0; leaf < index_.leaf_count(); ++leaf) {
      for (int i = 0; i < index_.LeafPoints(leaf); ++i) {
        field_.points[index_.positions(leaf).id[i]] = WithRadius(UndefinedCurvature(status));
      }
    }
  }

  PointCurvature WithRadius(PointCurvature point) const {
    if (plan_.by_radius) point.radius = static_cast<float>(plan_.radius);
    return point;
  }

  void FinishField() {
    for (const GroupScratch& scratch : scratch_) {
      for (int status = 0; status < kPointStatusEnd; ++status) {
        field_.status_counts[status] += scratch.status_counts()[status];
      }
    }
    cost_.queue_seconds = indexing_since_;
    cost_.index_seconds = estimating_since_ - indexing_since_;
    cost_.estimate_seconds = SecondsSinceStart() - estimating_since_;
    index_ = SpatialIndex();
    umbrellas_ = PageArray<Umbrella>();
    Finish(EstimationResult{std::move(field_), cost_});
  }

  void Finish(absl::StatusOr<EstimationResult> result) {
    ended_after_ = SecondsSinceStart();
    phase_ = JobPhase::kDone;
    scratch_.clear();
    Callback callback = std::move(callback_);
    callback(std::move(result));
  }

  double SecondsSinceStart() const { return std::chrono::duration<double>(Clock::now() - started_).count(); }

  Cloud cloud_;  // until the builder takes it
  const EstimatorOptions options_;
  WorkerPool& pool_;
  const JobPriority priority_;
  const CallerKey caller_;
  Callback callback_;
  const Clock::time_point started_;
  std::atomic<bool> cancelled_ = false;
  std::atomic<JobPhase> phase_ = JobPhase::kQueued;
  std::atomic<size_t> estimated_ = 0;
  // Seconds since started_.
  std::atomic<double> indexing_since_ = kNotYet;
  std::atomic<double> estimating_since_ = kNotYet;
  std::atomic<double> ended_after_ = kNotYet;
  std::atomic<int32_t> oversized_point_ = -1;
  std::optional<IndexBuilder> builder_;
  std::atomic<size_t> open_parts_ = 0;  // of the tree: submitted, and not done
  SpatialIndex index_;
  EstimationPlan plan_{};
  EstimationPlan umbrella_plan_{};
  size_t groups_per_block_ = kGroupsPerBlock;
  PageArray<Umbrella> umbrellas_;      // Delaunay only
  std::vector<GroupScratch> scratch_;  // one a worker
  CurvatureField field_;
  JobCost cost_;
  size_t point_count_ = 0;
  size_t invalid_count_ = 0;
};

}  // namespace

std::shared_ptr<EstimationJob> EstimationJob::Start(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool,
                                                    JobPriority priority, Callback callback, CallerKey caller) {
  auto job = std::make_shared<PhasedJob>(std::move(cloud), options, pool, priority, caller, std::move(callback));
  job->Start();
  return job;
}

absl::StatusOr<EstimationResult> EstimateCurvature(Cloud cloud, const EstimatorOptions& options, WorkerPool& pool) {
  absl::StatusOr<EstimationResult> result;
  std::latch done(1);
  EstimationJob::Start(std::move(cloud), options, pool, JobPriority::kBatch, [&](auto estimated) {
    result = std::move(estimated);
    done.count_down();
  });
  done.wait();
  return result;
}

}  // namespace curvd
