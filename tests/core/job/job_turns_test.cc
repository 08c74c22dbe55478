#include "core/job/job_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace curvd {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Duration = JobTurns::Duration;
constexpr auto kInteractive = JobPriority::kInteractive;
constexpr auto kBatch = JobPriority::kBatch;

// What a job is and costs. Jobs are told apart by their names.
struct Work {
  char name;
  CallerKey caller;
  JobPriority priority = kInteractive;
  size_t blocks = 1;
  Duration block_time = milliseconds(1);
  const std::atomic<bool>* stop = nullptr;
  std::function<void()> done = nullptr;  // called before the job is closed, as the pool does
};

// Runs blocks on a clock that stands still, but for the time that a block takes.
class Workers {
 public:
  explicit Workers(size_t count) : running_(count) {}

  void Add(Work work) {
    jobs_.push_back(std::make_unique<Job>(std::move(work), now_));
    turns_.Add(*jobs_.back());
  }

  // Lets idle workers begin a block, then ends the one that is over first. Returns false if there was none.
  bool Step() {
    for (auto& running : running_) {
      if (!running.has_value()) running = Begin();
    }
    const auto first = std::min_element(running_.begin(), running_.end(), [](const auto& a, const auto& b) {
      return a.has_value() && (!b.has_value() || a->ends < b->ends);
    });
    if (!first->has_value()) return false;
    const Running ended = **first;
    first->reset();
    End(ended);
    return true;
  }
  void RunUntil(Duration end) {
    while (now_ < end && Step()) {
    }
  }
  void RunToTheEnd() {
    while (Step()) {
    }
  }

  const JobTurns& turns() const { return turns_; }
  Duration now() const { return now_; }
  // Names of the jobs in the order in which their blocks began.
  const std::string& order() const { return order_; }
  // Worker time that the caller's blocks took.
  Duration used(CallerKey caller) { return used_[caller]; }
  // From Add to the end of the last block.
  Duration took(char name) const { return took_.at(name); }

 private:
  struct Job : JobTurns::Job {
    Job(Work its_work, Duration now)
        : JobTurns::Job(its_work.caller, its_work.priority, its_work.blocks, its_work.stop),
          work(std::move(its_work)),
          added(now) {}
    Work work;
    Duration added;
  };
  struct Running {
    JobTurns::Turn turn;
    Duration took;
    Duration ends;
  };

  std::optional<Running> Begin() {
    const std::optional<JobTurns::Turn> turn = turns_.Next();
    if (!turn.has_value()) return std::nullopt;
    const Work& work = static_cast<const Job*>(turn->job)->work;
    if (!turn->is_stopped) order_ += work.name;
    const Duration took = turn->is_stopped ? Duration::zero() : work.block_time;
    return Running{*turn, took, now_ + took};
  }

  void End(const Running& ended) {
    const Job& job = *static_cast<const Job*>(ended.turn.job);
    now_ = ended.ends;
    used_[job.work.caller] += ended.took;
    if (!turns_.End(ended.turn, ended.took)) return;
    took_[job.work.name] = now_ - job.added;
    if (job.work.done) job.work.done();
    turns_.Close(job);
  }

  JobTurns turns_;
  Duration now_{};
  std::vector<std::unique_ptr<Job>> jobs_;
  std::vector<std::optional<Running>> running_;
  std::string order_;
  std::map<CallerKey, Duration> used_;
  std::map<char, Duration> took_;
};

double Ratio(Duration a, Duration b) { return static_cast<double>(a.count()) / static_cast<double>(b.count()); }

TEST(JobTurnsTest, JobsOfACallerTakeTurnsBlockByBlock) {
  Workers workers(1);
  workers.Add({'a', 1, kBatch, 4});
  workers.Add({'b', 1, kBatch, 4});
  workers.RunToTheEnd();
  EXPECT_EQ(workers.order(), "abababab");
}

TEST(JobTurnsTest, OneTurnInEightOfACallerIsABatchJobs) {
  Workers workers(1);
  workers.Add({'b', 1, kBatch, 20});
  workers.Add({'i', 1, kInteractive, 20});
  workers.RunUntil(milliseconds(16));
  EXPECT_EQ(workers.order(), "iiiiiiibiiiiiiib");
}

TEST(JobTurnsTest, CallersWithEqualBlocksTakeTurnsHoweverManyJobsTheyHave) {
  Workers workers(1);
  for (int i = 0; i < 60; ++i) workers.Add({'a', 1, kInteractive, 100});
  workers.Add({'b', 2, kInteractive, 100});
  workers.RunUntil(milliseconds(100));
  const auto turns_of_b = std::count(workers.order().begin(), workers.order().end(), 'b');
  EXPECT_NEAR(static_cast<double>(turns_of_b), 50, 1);
}

TEST(JobTurnsTest, SharesAreOfWorkerTimeNotOfBlocks) {
  for (size_t count : {1, 2, 16}) {
    Workers workers(count);
    for (int i = 0; i < 20; ++i) workers.Add({'a', 1, kBatch, 10'000, milliseconds(20)});
    for (int i = 0; i < 20; ++i) workers.Add({'b', 2, kBatch, 100'000, milliseconds(1)});
    for (int i = 0; i < 20; ++i) workers.Add({'c', 3, kBatch, 100'000, microseconds(100)});
    workers.RunUntil(std::chrono::seconds(3));
    EXPECT_NEAR(Ratio(workers.used(1), workers.used(2)), 1.0, 0.05) << count << " workers";
    EXPECT_NEAR(Ratio(workers.used(3), workers.used(2)), 1.0, 0.05) << count << " workers";
  }
}

TEST(JobTurnsTest, ASmallJobOfAnotherCallerWaitsForOneBlock) {
  Workers workers(2);
  for (int i = 0; i < 60; ++i) workers.Add({'a', 1, kInteractive, 1'000});
  workers.RunUntil(std::chrono::seconds(10));
  // Four phases of one block, one after the other: 4 ms without anybody else.
  int phase = 0;
  std::function<void()> next = [&] {
    if (++phase < 4) workers.Add({'b', 2, kInteractive, 1, milliseconds(1), nullptr, next});
  };
  const Duration began = workers.now();
  workers.Add({'b', 2, kInteractive, 1, milliseconds(1), nullptr, next});
  while (phase < 4) workers.Step();
  EXPECT_LE(workers.now() - began, milliseconds(5));
}

TEST(JobTurnsTest, NobodySavesUpTurnsByBeingIdle) {
  Workers workers(1);
  workers.Add({'a', 1, kBatch, 1'000'000});
  workers.Add({'b', 2, kBatch, 1});
  workers.RunUntil(std::chrono::seconds(10));
  const Duration before = workers.used(1);
  workers.Add({'b', 2, kBatch, 1'000'000});
  workers.RunUntil(workers.now() + std::chrono::seconds(1));
  EXPECT_NEAR(Ratio(workers.used(1) - before, std::chrono::milliseconds(500)), 1.0, 0.01);
}

TEST(JobTurnsTest, WhoComesBackKeepsWhatItHasHad) {
  Workers workers(1);
  workers.Add({'a', 1, kBatch, 1'000'000});
  // A caller that ends each job at once and adds another has no more than its share.
  std::vector<Duration> used;
  while (workers.now() < std::chrono::seconds(4)) {
    workers.Add({'b', 2, kInteractive, 3});
    const Duration until = workers.used(2) + milliseconds(3);
    while (workers.used(2) < until) workers.Step();
  }
  EXPECT_NEAR(Ratio(workers.used(2), workers.used(1)), 1.0, 0.05);
}

TEST(JobTurnsTest, InteractiveWorkGoesBeforeTheBatchJobsOfOthersByItsLeadOnly) {
  Workers workers(1);
  workers.Add({'b', 1, kBatch, 100'000});
  workers.RunUntil(std::chrono::seconds(1));
  workers.Add({'i', 2, kInteractive, 100'000});
  const std::string::size_type began = workers.order().size();
  workers.RunUntil(std::chrono::seconds(2));
  const std::string order = workers.order().substr(began);
  const auto lead = order.find('b');
  EXPECT_NEAR(static_cast<double>(lead), Ratio(JobTurns::kInteractiveLead, milliseconds(1)), 1.5);
  const auto turns_of_b = std::count(order.begin() + lead, order.end(), 'b');
  EXPECT_NEAR(static_cast<double>(turns_of_b), (1'000.0 - lead) / 2, 2);
}

TEST(JobTurnsTest, AStreamOfInteractiveCallersDoesNotStarveABatchJob) {
  Workers workers(2);
  workers.Add({'b', 1, kBatch, 100'000});
  constexpr int kCallers = 50;
  for (int round = 0; round < 200; ++round) {
    for (CallerKey caller = 2; caller < 2 + kCallers; ++caller) workers.Add({'i', caller, kInteractive, 5});
    workers.RunUntil(workers.now() + milliseconds(50));
  }
  // Its share is one in 51; it waits for each caller's lead before.
  EXPECT_GT(Ratio(workers.used(1), 2 * workers.now()), 0.8 / (kCallers + 1));
}

TEST(JobTurnsTest, ALongBlockIsPaidForEvenIfNobodyExpectedIt) {
  Workers workers(1);
  workers.Add({'a', 1, kInteractive, 1, milliseconds(500)});
  workers.Step();  // it ran alone, and everybody begins level again
  workers.Add({'a', 1, kInteractive, 2, milliseconds(500)});
  workers.Add({'b', 2, kInteractive, 1'000});
  workers.RunUntil(milliseconds(1'600));
  EXPECT_EQ(workers.order().substr(0, 2), "aa");
  EXPECT_EQ(std::count(workers.order().begin(), workers.order().begin() + 400, 'a'), 2)
      << "its next block comes when the other has had as much";
}

TEST(JobTurnsTest, AStoppedJobIsLeftOutInItsNextTurnAndCostsNothing) {
  Workers workers(1);
  std::atomic<bool> stop = false;
  workers.Add({'a', 1, kBatch, 1'000, milliseconds(1), &stop});
  workers.Add({'b', 1, kBatch, 3});
  workers.Step();
  stop = true;
  workers.RunToTheEnd();
  EXPECT_EQ(workers.order(), "abbb");
  EXPECT_EQ(workers.took('a'), milliseconds(2)) << "it ended in its next turn";
}

TEST(JobTurnsTest, CountsWhatWaitsAndWhatIsOpen) {
  JobTurns turns;
  JobTurns::Job job(7, kBatch, 2, nullptr);
  turns.Add(job);
  EXPECT_EQ(turns.waiting_count(), 1u);
  const auto first = *turns.Next(), second = *turns.Next();
  EXPECT_FALSE(turns.Next().has_value());
  EXPECT_EQ(turns.waiting_count(), 0u);
  EXPECT_FALSE(turns.End(second, milliseconds(1)));
  EXPECT_TRUE(turns.End(first, milliseconds(1)));
  EXPECT_EQ(turns.open_count(), 1u);
  turns.Close(job);
  EXPECT_EQ(turns.open_count(), 0u);
}

TEST(JobTurnsTest, RemembersOnlyCallersWhoHaveHadMoreThanOthers) {
  Workers workers(1);
  workers.Add({'a', 1, kBatch, 1'000'000});
  for (CallerKey caller = 2; caller < 500; ++caller) workers.Add({'b', caller, kBatch, 1});
  workers.RunUntil(std::chrono::seconds(2));
  EXPECT_EQ(workers.turns().caller_count(), 1u);
}

TEST(JobTurnsTest, ForgetsEverybodyOnceNoJobIsOpen) {
  Workers workers(1);
  for (CallerKey caller = 1; caller < 10; ++caller) workers.Add({'a', caller, kInteractive, caller});
  workers.RunToTheEnd();
  EXPECT_EQ(workers.turns().caller_count(), 0u);
}

}  // namespace
}  // namespace curvd
