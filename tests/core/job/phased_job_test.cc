#include "core/job/phased_job.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <latch>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace curvd {
namespace {

// A phase of functions; those that are not given do nothing.
struct TestPhase final : Phase {
  std::string_view phase_name = "phase";
  size_t blocks = 1;
  std::function<absl::Status()> begin;
  std::function<absl::Status(const BlockContext&)> run;
  std::function<absl::Status()> end;

  std::string_view name() const override { return phase_name; }
  absl::StatusOr<size_t> Begin() override {
    if (begin) {
      if (absl::Status status = begin(); !status.ok()) return status;
    }
    return blocks;
  }
  absl::Status RunBlock(const BlockContext& context) override { return run ? run(context) : absl::OkStatus(); }
  absl::Status End() override { return end ? end() : absl::OkStatus(); }
};

class TestJob final : public PhasedJob {
 public:
  explicit TestJob(WorkerPool& pool) : PhasedJob(pool, JobPriority::kBatch) {}

  TestPhase& Add(std::string_view name, size_t blocks) {
    auto phase = std::make_unique<TestPhase>();
    TestPhase& added = *phase;
    phase->phase_name = name;
    phase->blocks = blocks;
    AddPhase(std::move(phase));
    return added;
  }

  absl::Status RunToEnd() {
    Run();
    done_.wait();
    return status_;
  }

  using PhasedJob::peak_bytes;
  std::atomic<size_t> held = 0;

 private:
  size_t HeldBytes() const override { return held; }
  void OnEnd(absl::Status status) override {
    status_ = std::move(status);
    done_.count_down();
  }

  std::latch done_{1};
  absl::Status status_;
};

// Names of phases in the order in which they are told, without the times.
std::vector<std::string> NamesOf(const std::vector<PhaseTime>& times) {
  std::vector<std::string> names;
  for (const PhaseTime& time : times) names.emplace_back(time.name);
  return names;
}

TEST(PhasedJobTest, PhasesRunInOrderEachAfterAllBlocksOfTheOneBefore) {
  for (const int threads : {1, 4}) {
    WorkerPool pool(threads);
    const auto job = std::make_shared<TestJob>(pool);
    std::atomic<int> first = 0, second = 0;
    job->Add("first", 100).run = [&](const BlockContext&) {
      ++first;
      return absl::OkStatus();
    };
    job->Add("second", 50).run = [&](const BlockContext&) {
      EXPECT_EQ(first, 100);
      ++second;
      return absl::OkStatus();
    };
    EXPECT_TRUE(job->RunToEnd().ok());
    EXPECT_EQ(second, 50);
    EXPECT_EQ(NamesOf(job->phase_times()), (std::vector<std::string>{"queue", "first", "second"}));
  }
}

TEST(PhasedJobTest, AJobWithoutBlocksEndsWithoutAThread) {
  WorkerPool pool(1);
  const auto job = std::make_shared<TestJob>(pool);
  bool ended = false;
  job->Add("nothing", 0).end = [&] {
    ended = true;
    return absl::OkStatus();
  };
  EXPECT_TRUE(job->RunToEnd().ok());
  EXPECT_TRUE(ended);
  EXPECT_EQ(NamesOf(job->phase_times()), (std::vector<std::string>{"queue"}));
}

TEST(PhasedJobTest, ABlockMayAddBlocksAndThePhaseEndsAfterThem) {
  WorkerPool pool(4);
  const auto job = std::make_shared<TestJob>(pool);
  std::atomic<int> runs = 0;
  TestPhase& tree = job->Add("tree", 1);
  tree.run = [&](const BlockContext& context) {
    ++runs;
    if (context.block < 63) {
      context.add_block(2 * context.block + 1);
      context.add_block(2 * context.block + 2);
    }
    return absl::OkStatus();
  };
  tree.end = [&] {
    EXPECT_EQ(runs, 1 + 2 + 4 + 8 + 16 + 32 + 64);
    return absl::OkStatus();
  };
  EXPECT_TRUE(job->RunToEnd().ok());
}

TEST(PhasedJobTest, APhaseMayAddPhases) {
  WorkerPool pool(2);
  const auto job = std::make_shared<TestJob>(pool);
  std::atomic<bool> late = false;
  job->Add("first", 3).end = [&] {
    job->Add("second", 3).run = [&](const BlockContext&) {
      late = true;
      return absl::OkStatus();
    };
    return absl::OkStatus();
  };
  EXPECT_TRUE(job->RunToEnd().ok());
  EXPECT_TRUE(late);
}

TEST(PhasedJobTest, TheFirstErrorEndsTheJobAndLeavesOutTheBlocksThatFollow) {
  WorkerPool pool(1);
  const auto job = std::make_shared<TestJob>(pool);
  int runs = 0;
  job->Add("fails", 1000).run = [&](const BlockContext& context) {
    ++runs;
    return context.block == 3 ? MakeCoreError(ErrorKind::kNeighborhoodTooLarge, "block 3") : absl::OkStatus();
  };
  job->Add("never", 1).begin = [] {
    ADD_FAILURE();
    return absl::OkStatus();
  };
  const absl::Status status = job->RunToEnd();
  EXPECT_EQ(KindOf(status), ErrorKind::kNeighborhoodTooLarge);
  EXPECT_EQ(status.message(), "block 3");
  EXPECT_EQ(runs, 4);
}

TEST(PhasedJobTest, BadAllocAnywhereIsOutOfMemory) {
  const auto fail = []() -> absl::Status { throw std::bad_alloc(); };
  for (const int place : {0, 1, 2}) {
    WorkerPool pool(2);
    const auto job = std::make_shared<TestJob>(pool);
    TestPhase& phase = job->Add("greedy", 100);
    if (place == 0) phase.begin = fail;
    if (place == 1)
      phase.run = [&](const BlockContext& context) { return context.block == 7 ? fail() : absl::OkStatus(); };
    if (place == 2) phase.end = fail;
    const absl::Status status = job->RunToEnd();
    EXPECT_EQ(KindOf(status), ErrorKind::kOutOfMemory) << place;
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  }
}

TEST(PhasedJobTest, CancelEndsThePhaseThatRuns) {
  WorkerPool pool(1);
  const auto job = std::make_shared<TestJob>(pool);
  int runs = 0;
  job->Add("work", 1'000'000).run = [&](const BlockContext& context) {
    ++runs;
    EXPECT_FALSE(context.stopped);
    job->Cancel();
    EXPECT_TRUE(context.stopped);
    return absl::OkStatus();
  };
  const absl::Status status = job->RunToEnd();
  EXPECT_EQ(KindOf(status), ErrorKind::kCancelled);
  EXPECT_EQ(status.message(), "cancelled in the phase \"work\"");
  EXPECT_EQ(runs, 1);
}

TEST(PhasedJobTest, PeakIsTheMostHeldAtTheEndsOfPhases) {
  WorkerPool pool(1);
  const auto job = std::make_shared<TestJob>(pool);
  const auto hold = [&](size_t bytes) {
    return [&job, bytes] {
      job->held = bytes;
      return absl::OkStatus();
    };
  };
  job->Add("a", 1).begin = hold(100);
  job->Add("b", 1).end = hold(300);
  job->Add("c", 1).begin = hold(200);
  EXPECT_TRUE(job->RunToEnd().ok());
  EXPECT_EQ(job->peak_bytes(), 300u);
}

TEST(PhasedJobTest, PhasesInARowWithOneNameAreTimedTogether) {
  WorkerPool pool(1);
  const auto job = std::make_shared<TestJob>(pool);
  job->Add("index", 1);
  job->Add("index", 0);
  job->Add("index", 2);
  job->Add("estimate", 1);
  EXPECT_TRUE(job->RunToEnd().ok());
  const std::vector<PhaseTime> times = job->phase_times();
  EXPECT_EQ(NamesOf(times), (std::vector<std::string>{"queue", "index", "estimate"}));
  EXPECT_GT(SecondsOf(times, "index"), 0.0);
  EXPECT_EQ(SecondsOf(times, "index"), job->phase_times()[1].seconds);  // the time has stopped
  EXPECT_EQ(SecondsOf(times, "unknown"), 0.0);
}

}  // namespace
}  // namespace curvd
