// A fixed set of threads that serves many jobs in turn, one work block at a time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// Blocks of interactive jobs go before blocks of batch jobs, save that every eighth block is a batch's.
enum class JobPriority : uint8_t { kInteractive, kBatch };

// Thread-safe.
class WorkerPool {
 public:
  // Runs one block; `worker` in [0, thread_count()) names the thread, for scratch that threads do not share.
  using BlockFunction = std::function<void(size_t block, int worker)>;

  // REQUIRES: thread_count >= 1.
  explicit WorkerPool(int thread_count);
  // Runs what was submitted to its end, then joins the threads.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Runs `run` once for each block in [0, block_count), in no particular order and on any threads, then `done` once on
  // the thread that finished last. Both may submit again. Jobs of equal priority take turns block by block. Once *stop
  // is true (if there is a stop), blocks that have not begun are left out, all in the job's next turn: a job that
  // nobody wants does not hold its memory until others have had as many turns as it has blocks.
  // Throws std::bad_alloc, having done nothing, if there is no memory for the job; the threads themselves allocate
  // nothing.
  // REQUIRES: block_count >= 1; a block takes milliseconds, not seconds; neither function blocks or throws; *stop lives
  // until `done` is called.
  void Submit(JobPriority priority, size_t block_count, BlockFunction run, std::function<void()> done,
              const std::atomic<bool>* stop = nullptr);

  int thread_count() const { return static_cast<int>(threads_.size()); }
  // Threads that run a block now.
  int busy_count() const;
  // Submitted jobs that have blocks left to hand out.
  size_t waiting_count() const;

 private:
  struct Job;
  // Jobs move between lists by their nodes, so that a thread that takes turns needs no memory.
  using Queue = std::list<std::shared_ptr<Job>>;

  void RunWorker(int worker);
  Queue& NextQueue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  CondVar work_changed_;
  Queue interactive_ ABSL_GUARDED_BY(mutex_);
  Queue batch_ ABSL_GUARDED_BY(mutex_);
  size_t open_jobs_ ABSL_GUARDED_BY(mutex_) = 0;
  uint32_t turn_ ABSL_GUARDED_BY(mutex_) = 0;
  int busy_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace curvd
