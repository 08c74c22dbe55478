#include "core/job/worker_pool.h"

#include <utility>

namespace curvd {

struct WorkerPool::Job {
  JobPriority priority;
  size_t block_count;
  BlockFunction run;
  std::function<void()> done;
  const std::atomic<bool>* stop;
  size_t next_block = 0;       // guarded by the pool's mutex
  size_t finished_blocks = 0;  // guarded by the pool's mutex

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

WorkerPool::WorkerPool(int thread_count) {
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
                        const std::atomic<bool>* stop) {
  Queue job;
  job.push_back(std::make_shared<Job>(Job{priority, block_count, std::move(run), std::move(done), stop}));
  {
    MutexLock lock(mutex_);
    ++open_jobs_;
    Queue& queue = priority == JobPriority::kInteractive ? interactive_ : batch_;
    queue.splice(queue.end(), job);
  }
  block_count == 1 ? work_changed_.NotifyOne() : work_changed_.NotifyAll();
}

int WorkerPool::busy_count() const {
  MutexLock lock(mutex_);
  return busy_;
}

size_t WorkerPool::waiting_count() const {
  MutexLock lock(mutex_);
  return interactive_.size() + batch_.size();
}

bool WorkerPool::HasWork() const { return !interactive_.empty() || !batch_.empty() || (stopping_ && open_jobs_ == 0); }

WorkerPool::Queue& WorkerPool::NextQueue() {
  // Every eighth block is a batch's, so that no flood of small clouds can starve the large ones.
  constexpr uint32_t kBatchTurn = 8;
  const bool batch_turn = ++turn_ % kBatchTurn == 0;
  if (interactive_.empty()) return batch_;
  return batch_turn && !batch_.empty() ? batch_ : interactive_;
}

void WorkerPool::RunWorker(int worker) {
  while (true) {
    std::shared_ptr<Job> job;
    Queue handed_out;  // the job, once all of its blocks are
    size_t block;
    size_t count;  // of blocks that this turn does away with
    bool stopped;
    {
      MutexLock lock(mutex_);
      while (!HasWork()) work_changed_.Wait(mutex_);
      Queue& queue = NextQueue();
      if (queue.empty()) return;
      job = queue.front();
      stopped = job->stopped();
      count = stopped ? job->block_count - job->next_block : 1;
      block = std::exchange(job->next_block, job->next_block + count);
      // Back to the end of the queue: jobs take turns.
      Queue& next = job->next_block < job->block_count ? queue : handed_out;
      next.splice(next.end(), queue, queue.begin());
      ++busy_;
    }
    if (!stopped) job->run(block, worker);
    bool last;
    {
      MutexLock lock(mutex_);
      --busy_;
      job->finished_blocks += count;
      last = job->finished_blocks == job->block_count;
    }
    if (last) {
      job->run = nullptr;
      job->done();
      job->done = nullptr;
      {
        MutexLock lock(mutex_);
        --open_jobs_;
      }
      work_changed_.NotifyAll();  // the pool may wait for its last job
    }
  }
}

}  // namespace curvd
