// What becomes of a job when the n-th allocation finds no memory, for every n, or for some all over the job.
#include <gtest/gtest.h>

#include <latch>
#include <memory>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/job/estimation_job.h"
#include "core/job/phased_job.h"
#include "tests/core/failing_new.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

struct Outcome {
  int calls = 0;
  absl::Status status;
  bool has_failed = false;
};

// Runs a job of which an allocation fails: the one after `first` others, or all from there on.
Outcome RunWithFailure(const TestPoints& points, const EstimatorOptions& options, int threads, size_t first,
                       FailingNew::Failing failing, const NormalOptions& normals) {
  Outcome outcome;
  Cloud cloud = points.ToCloud();
  WorkerPool pool(threads);
  std::latch done(1);
  // As small as a reference: std::function has room for it.
  struct State {
    Outcome& outcome;
    std::latch& done;
  } state{outcome, done};
  EstimationJob::Callback callback = [&state](absl::StatusOr<EstimationResult> result) {
    ++state.outcome.calls;
    state.outcome.status = result.status();
    if (state.outcome.calls == 1) state.done.count_down();
  };
  FailingNew failure(first, failing);
  const std::shared_ptr<EstimationJob> job =
      EstimationJob::Start(std::move(cloud), options, normals, pool, JobPriority::kBatch, std::move(callback));
  done.wait();
  failure.Stop();
  EXPECT_EQ(job->progress().phase, JobPhase::kDone);
  job->Cancel();
  outcome.has_failed = failure.has_failed();
  return outcome;
}

// Runs the job with one failure after the other, until there is none.
void FailEachAllocation(const TestPoints& points, const EstimatorOptions& options, int threads,
                        FailingNew::Failing failing, const NormalOptions& normals = {}) {
  (void)RunWithFailure(points, options, threads, size_t{1} << 40, failing, normals);  // makes what lives on
  for (size_t first = 0;; ++first) {
    const ptrdiff_t before = LiveAllocations();
    const Outcome outcome = RunWithFailure(points, options, threads, first, failing, normals);
    ASSERT_EQ(outcome.calls, 1) << "allocation " << first;
    ASSERT_EQ(LiveAllocations(), before) << "allocation " << first;
    if (!outcome.has_failed) {
      ASSERT_TRUE(outcome.status.ok()) << outcome.status;
      ASSERT_GT(first, 20u);
      return;
    }
    ASSERT_EQ(KindOf(outcome.status), ErrorKind::kOutOfMemory) << "allocation " << first << ": " << outcome.status;
  }
}

class StrategyOutOfMemoryTest : public ::testing::TestWithParam<std::string_view> {};

INSTANTIATE_TEST_SUITE_P(EachStrategy, StrategyOutOfMemoryTest, ::testing::Values("avg-hexagram", "delaunay", "jet"),
                         [](const auto& info) {
                           return std::string(info.param == "avg-hexagram" ? "hexagram" : info.param);
                         });

// More than one subtree, so that blocks add blocks.
TestPoints ManyPoints() { return Sphere(20'000, 1.0); }

TEST_P(StrategyOutOfMemoryTest, AnyAllocationThatFailsIsOutOfMemoryAndNothingLeaks) {
  const EstimatorOptions options = {.estimator = GetParam(), .neighborhood = NeighborCount{8}};
  FailEachAllocation(ManyPoints(), options, 1, FailingNew::Failing::kOne);
}

TEST_P(StrategyOutOfMemoryTest, AllAllocationsThatFailFromSomeOneOnAreOutOfMemory) {
  const EstimatorOptions options = {.estimator = GetParam(), .neighborhood = NeighborCount{8}};
  FailEachAllocation(ManyPoints(), options, 2, FailingNew::Failing::kAllFromThere);
}

TEST(NormalsOutOfMemoryTest, AnyAllocationThatFailsIsOutOfMemoryAndNothingLeaks) {
  const EstimatorOptions options = {.neighborhood = NeighborCount{8}};
  NormalOptions normals;
  normals.source = NormalSource::kEstimate;
  normals.returns_normals = true;
  FailEachAllocation(Sphere(200, 1.0), options, 1, FailingNew::Failing::kOne, normals);
  normals.neighborhood = NeighborCount{8};
  FailEachAllocation(Sphere(500, 1.0), options, 2, FailingNew::Failing::kAllFromThere, normals);
}

// One half is noisy, so that parts are found and more points sampled; outliers make it two passes. The job has too many
// allocations to let each fail.
TEST(AutomaticOutOfMemoryTest, AllocationsThatFailAnywhereAreOutOfMemoryAndNothingLeaks) {
  TestPoints points = Sphere(9'000, 1.0), noisy = points;
  AddNoise(0.01, 3, noisy);
  for (size_t i = 0; i < points.size(); ++i) {
    if (points.positions[i][0] > 0.0f) points.positions[i] = noisy.positions[i];
  }
  for (int i = 1; i <= 9; ++i) points.Add(1.0 + 0.3 * i, 0.0, 0.0, 1.0, 0.0, 0.0);
  EstimatorOptions options = {.estimator = "auto", .neighborhood = AutomaticScale{}};
  options.returns_choice = true;
  const EstimationResult whole = MustEstimate(points.ToCloud(), options);
  ASSERT_GT(whole.field.status_counts[static_cast<size_t>(PointStatus::kOutlier)], 0u);
  size_t refusals = 0, failures = 0;
  const auto fail = [&](size_t first, FailingNew::Failing failing) {
    const ptrdiff_t before = LiveAllocations();
    const Outcome outcome = RunWithFailure(points, options, 2, first, failing, {});
    EXPECT_EQ(outcome.calls, 1) << "allocation " << first;
    EXPECT_EQ(LiveAllocations(), before) << "allocation " << first;
    // Points are split in place where std::stable_partition finds no memory.
    EXPECT_TRUE(outcome.status.ok() || KindOf(outcome.status) == ErrorKind::kOutOfMemory) << outcome.status;
    failures += outcome.has_failed ? 1 : 0;
    refusals += outcome.status.ok() ? 0 : 1;
    EXPECT_TRUE(outcome.has_failed || outcome.status.ok());
    return outcome.has_failed;
  };
  (void)RunWithFailure(points, options, 2, size_t{1} << 40, FailingNew::Failing::kOne, {});  // makes what lives on
  size_t first = 0;
  while (fail(first, FailingNew::Failing::kOne) && fail(first + 1, FailingNew::Failing::kAllFromThere)) {
    first += 10 + first / 2;
  }
  EXPECT_GT(first, 10'000u);
  EXPECT_GE(refusals + 2, failures);
}

class EmptyPhase final : public Phase {
 public:
  explicit EmptyPhase(std::string_view name) : name_(name) {}
  std::string_view name() const override { return name_; }
  absl::StatusOr<size_t> Begin() override { return 1; }
  absl::Status RunBlock(const BlockContext& /*context*/) override { return absl::OkStatus(); }

 private:
  const std::string_view name_;
};

class ManyPhases final : public PhasedJob {
 public:
  explicit ManyPhases(WorkerPool& pool) : PhasedJob(pool, JobPriority::kBatch) {
    for (size_t i = 0; i < kNames.size(); ++i) AddPhase(std::make_unique<EmptyPhase>(kNames.substr(i, 1)));
  }
  absl::Status RunToEnd() {
    Run();
    done_.wait();
    return status_;
  }

  static constexpr std::string_view kNames = "abcdefghijklmnopqrstuvwxyz";

 private:
  size_t HeldBytes() const override { return 0; }
  void OnEnd(absl::Status status) override {
    status_ = std::move(status);
    done_.count_down();
  }

  std::latch done_{1};
  absl::Status status_;
};

TEST(PhasesOutOfMemoryTest, TheTimesOfManyPhasesNeedNoMemoryWhileTheyRun) {
  for (size_t first = 0;; ++first) {
    WorkerPool pool(1);
    const auto job = std::make_shared<ManyPhases>(pool);
    FailingNew failure(first, FailingNew::Failing::kOne);
    const absl::Status status = job->RunToEnd();
    failure.Stop();
    if (!failure.has_failed()) {
      EXPECT_TRUE(status.ok()) << status;
      EXPECT_EQ(job->phase_times().size(), 1 + ManyPhases::kNames.size());
      return;
    }
    ASSERT_EQ(KindOf(status), ErrorKind::kOutOfMemory) << "allocation " << first;
  }
}

}  // namespace
}  // namespace curvd::testing
