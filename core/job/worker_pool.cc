#include "core/job/worker_pool.h"

#include <chrono>
#include <memory>
#include <utility>

#include "core/base/out_of_memory.h"

namespace curvd {

struct WorkerPool::Job : JobTurns::Job {
  Job(CallerKey caller, JobPriority priority, size_t block_count, const std::atomic<bool>* stop,
      BlockFunction run_block, std::function<void()> all_done)
      : JobTurns::Job(caller, priority, block_count, stop), run(std::move(run_block)), done(std::move(all_done)) {}

  BlockFunction run;
  std::function<void()> done;
};

WorkerPool::WorkerPool(int thread_count) {
  PrepareOutOfMemoryError();
  threads_.reserve(thread_count);
  for (int worker = 0; worker < thread_count; ++worker) {
    threads_.emplace_back([this, worker] { RunWorker(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
  }
  work_changed_.NotifyAll();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::Submit(JobPriority priority, size_t block_count, BlockFunction run, std::function<void()> done,
                        const std::atomic<bool>* stop, CallerKey caller) {
  auto job = std::make_unique<Job>(caller, priority, block_count, stop, std::move(run), std::move(done));
  {
    MutexLock lock(mutex_);
    turns_.Add(*job);
    static_cast<void>(job.release());  // EndJob deletes it
  }
  block_count == 1 ? work_changed_.NotifyOne() : work_changed_.NotifyAll();
}

int WorkerPool::busy_count() const {
  MutexLock lock(mutex_);
  return busy_;
}

size_t WorkerPool::waiting_count() const {
  MutexLock lock(mutex_);
  return turns_.waiting_count();
}

std::optional<JobTurns::Turn> WorkerPool::WaitForTurn() {
  MutexLock lock(mutex_);
  while (true) {
    std::optional<JobTurns::Turn> turn = turns_.Next();
    if (turn.has_value()) {
      ++busy_;
      return turn;
    }
    if (stopping_ && turns_.open_count() == 0) return std::nullopt;
    work_changed_.Wait(mutex_);
  }
}

bool WorkerPool::EndTurn(const JobTurns::Turn& turn, JobTurns::Duration took) {
  MutexLock lock(mutex_);
  --busy_;
  return turns_.End(turn, took);
}

void WorkerPool::EndJob(Job* job) {
  const std::unique_ptr<Job> owned(job);
  job->run = nullptr;
  job->done();
  job->done = nullptr;
  bool was_last = false;
  {
    MutexLock lock(mutex_);
    turns_.Close(*job);
    was_last = stopping_ && turns_.open_count() == 0;
  }
  if (was_last) work_changed_.NotifyAll();
}

void WorkerPool::RunWorker(int worker) {
  using Clock = std::chrono::steady_clock;
  while (const std::optional<JobTurns::Turn> turn = WaitForTurn()) {
    Job* const job = static_cast<Job*>(turn->job);
    JobTurns::Duration took{};
    if (!turn->is_stopped) {
      const Clock::time_point began = Clock::now();
      job->run(turn->block, worker);
      took = Clock::now() - began;
    }
    if (EndTurn(*turn, took)) EndJob(job);
  }
}

}  // namespace curvd
