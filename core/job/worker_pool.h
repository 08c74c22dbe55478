// A fixed set of threads that runs the blocks of many jobs in the order of JobTurns.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "core/job/job_turns.h"

namespace curvd {

// Callers take turns by the time that their blocks took, and the jobs of a caller block by block; job_turns.h says how.
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
  // the thread that finished last. Both may submit again. Once *stop is true (if there is a stop), blocks that have not
  // begun are left out, all in the job's next turn: a job that nobody wants does not hold its memory until others have
  // had as many turns as it has blocks. `caller`: for whom the job runs, and with whose other jobs it shares its turns;
  // a job that `done` or `run` submits for the same caller goes on where the first one was.
  // If this throws std::bad_alloc, nothing was submitted.
  // REQUIRES: block_count >= 1; a block takes milliseconds, not seconds; neither function blocks or throws; *stop lives
  // until `done` is called.
  void Submit(JobPriority priority, size_t block_count, BlockFunction run, std::function<void()> done,
              const std::atomic<bool>* stop = nullptr, CallerKey caller = 0);

  int thread_count() const { return static_cast<int>(threads_.size()); }
  // Threads that run a block now.
  int busy_count() const;
  // Submitted jobs that have blocks left to hand out.
  size_t waiting_count() const;

 private:
  struct Job;

  void RunWorker(int worker);
  // Waits for a turn; nothing if the pool ends.
  std::optional<JobTurns::Turn> WaitForTurn();
  // Returns whether it was the last turn of its job.
  bool EndTurn(const JobTurns::Turn& turn, JobTurns::Duration took);
  void EndJob(Job* job);

  mutable Mutex mutex_;
  CondVar work_changed_;
  JobTurns turns_ ABSL_GUARDED_BY(mutex_);
  int busy_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace curvd
