#include "core/job/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <string>

namespace curvd {
namespace {

TEST(WorkerPoolTest, RunsEachBlockOnceThenDoneOnce) {
  for (int threads : {1, 4}) {
    std::vector<std::atomic<int>> runs(1000);
    std::atomic<int> done = 0;
    {
      WorkerPool pool(threads);
      pool.Submit(
          JobPriority::kBatch, runs.size(), [&](size_t block, int) { ++runs[block]; }, [&] { ++done; });
    }
    for (const auto& count : runs) EXPECT_EQ(count, 1);
    EXPECT_EQ(done, 1);
  }
}

TEST(WorkerPoolTest, WorkerNumbersAreDistinctAmongBlocksThatRunTogether) {
  constexpr int kThreads = 4;
  std::atomic<int> inside[kThreads] = {};
  std::atomic<bool> clash = false;
  {
    WorkerPool pool(kThreads);
    pool.Submit(
        JobPriority::kBatch, 10'000,
        [&](size_t, int worker) {
          if (++inside[worker] != 1) clash = true;
          --inside[worker];
        },
        [] {});
  }
  EXPECT_FALSE(clash);
}

TEST(WorkerPoolTest, EqualJobsTakeTurns) {
  WorkerPool pool(1);
  std::latch gate(1), done(1);
  std::string order;
  // Holds the only thread until both jobs wait.
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { gate.wait(); }, [] {});
  pool.Submit(
      JobPriority::kBatch, 4, [&](size_t, int) { order += 'a'; }, [] {});
  pool.Submit(
      JobPriority::kBatch, 4, [&](size_t, int) { order += 'b'; }, [&] { done.count_down(); });
  gate.count_down();
  done.wait();
  EXPECT_EQ(order, "abababab");
}

TEST(WorkerPoolTest, InteractiveJobsGoFirstButDoNotStarveBatches) {
  std::latch gate(1);
  std::string order;
  {
    WorkerPool pool(1);
    pool.Submit(
        JobPriority::kBatch, 1, [&](size_t, int) { gate.wait(); }, [] {});
    pool.Submit(
        JobPriority::kBatch, 4, [&](size_t, int) { order += 'b'; }, [] {});
    pool.Submit(
        JobPriority::kInteractive, 20, [&](size_t, int) { order += 'i'; }, [] {});
    gate.count_down();
  }
  EXPECT_EQ(order.front(), 'i');
  EXPECT_LT(order.find('b'), order.rfind('i')) << order;
}

TEST(WorkerPoolTest, AnotherCallerGoesBeforeTheJobsOfOneThatHasHadItsTurn) {
  WorkerPool pool(1);
  std::latch gate(1), done(1);
  std::string order;
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { gate.wait(); }, [] {}, nullptr, 1);
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { order += 'a'; }, [&] { done.count_down(); }, nullptr, 1);
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { order += 'b'; }, [] {}, nullptr, 2);
  gate.count_down();
  done.wait();
  EXPECT_EQ(order, "ba");
}

TEST(WorkerPoolTest, LeavesOutTheRestOfAStoppedJobInItsNextTurn) {
  WorkerPool pool(1);
  std::latch gate(1), done(1);
  std::atomic<bool> stop = false;
  std::string order;
  pool.Submit(
      JobPriority::kBatch, 1, [&](size_t, int) { gate.wait(); }, [] {});
  pool.Submit(
      JobPriority::kBatch, 1'000,
      [&](size_t, int) {
        order += 'a';
        stop = true;
      },
      [&] { order += '.'; }, &stop);
  pool.Submit(
      JobPriority::kBatch, 3, [&](size_t, int) { order += 'b'; }, [&] { done.count_down(); });
  gate.count_down();
  done.wait();
  EXPECT_EQ(order, "ab.bb");
}

TEST(WorkerPoolTest, AJobThatIsStoppedBeforeItBeginsIsDoneAllTheSame) {
  std::atomic<bool> stop = true;
  std::atomic<int> runs = 0, done = 0;
  {
    WorkerPool pool(2);
    pool.Submit(
        JobPriority::kInteractive, 100, [&](size_t, int) { ++runs; }, [&] { ++done; }, &stop);
  }
  EXPECT_EQ(runs, 0);
  EXPECT_EQ(done, 1);
}

TEST(WorkerPoolTest, DoneMaySubmitTheNextPhase) {
  std::atomic<int> phases = 0;
  {
    std::function<void()> next;  // outlives the pool, which runs it to the end
    WorkerPool pool(2);
    const auto submit = [&] {
      pool.Submit(
          JobPriority::kBatch, 3, [](size_t, int) {}, [&] { next(); });
    };
    next = [&] {
      if (++phases < 5) submit();
    };
    submit();
  }
  EXPECT_EQ(phases, 5);
}

TEST(WorkerPoolTest, CountsFallToZeroWhenIdle) {
  WorkerPool pool(2);
  std::latch done(1);
  pool.Submit(
      JobPriority::kBatch, 8, [](size_t, int) {}, [&] { done.count_down(); });
  done.wait();
  EXPECT_EQ(pool.waiting_count(), 0u);
  EXPECT_EQ(pool.busy_count(), 0);
}

}  // namespace
}  // namespace curvd
