// Runs a list of phases on a worker pool: the one place for cancelling, errors, running out of memory, times and peaks.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "core/base/phase.h"
#include "core/job/worker_pool.h"

namespace curvd {

// Wall-clock time that passed in the phases of one name.
struct PhaseTime {
  std::string_view name;
  double seconds;
};

// The name of the time before the first block of a job begins.
inline constexpr std::string_view kQueuePhase = "queue";

// The seconds of the phases of that name; 0 if there are none.
double SecondsOf(const std::vector<PhaseTime>& times, std::string_view name);

// A job that is a list of phases. The end of each phase begins the next one, on the thread that ran its last block, so
// that no thread waits for another. Derived classes add the phases, and own what the phases work on.
//
// The job lives at least until it has ended: the functions that the pool holds keep it alive. Thread-safe, save for
// AddPhase.
class PhasedJob : public std::enable_shared_from_this<PhasedJob> {
 public:
  PhasedJob(const PhasedJob&) = delete;
  PhasedJob& operator=(const PhasedJob&) = delete;
  virtual ~PhasedJob() = default;

  // Asks the job to end with ErrorKind::kCancelled. Blocks that run go on until their phase looks at
  // BlockContext::stopped; no other block of the job begins. The job ends when those are over and the pool has come to
  // the job's next turn, before which blocks of others may run. No effect once the last block of the last phase has
  // ended, nor on the error of a job that has failed. Allocates nothing.
  void Cancel();

  // The times of the phases that the job came to, kQueuePhase first; of the last one until now, or until the job's end.
  // Phases in a row that share a name are one.
  std::vector<PhaseTime> phase_times() const ABSL_LOCKS_EXCLUDED(times_mutex_);
  // Calls visit(phase) for each of them, in order. Allocates nothing. REQUIRES: `visit` asks the job for no times.
  void VisitPhaseTimes(absl::FunctionRef<void(const PhaseTime&)> visit) const ABSL_LOCKS_EXCLUDED(times_mutex_);
  bool ended() const { return ended_; }

 protected:
  // `caller`: for whom the job runs, as WorkerPool::Submit takes it. REQUIRES: `pool` lives until the job has ended.
  PhasedJob(WorkerPool& pool, JobPriority priority, CallerKey caller = 0);

  // Adds a phase at the end of the list. If this throws std::bad_alloc, none was added.
  // REQUIRES: called before Run, or by Begin or End of a phase of this job.
  void AddPhase(std::unique_ptr<Phase> phase) ABSL_LOCKS_EXCLUDED(times_mutex_);

  // Begins the first phase; if `status` is an error, ends the job with it instead. Throws nothing.
  // REQUIRES: called once, on a job that a shared_ptr owns.
  void Run(absl::Status status = absl::OkStatus());

  // True once the job was cancelled or has failed.
  const std::atomic<bool>& stopped() const { return stopped_; }
  WorkerPool& pool() { return pool_; }

  // Bytes of the large arrays that the job holds now. Asked for between blocks only.
  virtual size_t HeldBytes() const = 0;

  // Called once at the job's end, on the thread that ran the last block (or within Run, if no block ran), after the
  // phases were destroyed. Must not throw. Errors, of which the first that came counts, save that kCancelled gives way
  // to the others:
  // - what Run was given, or a phase returned,
  // - ErrorKind::kOutOfMemory if a phase threw std::bad_alloc, or there was no memory to hand its blocks to the pool,
  // - ErrorKind::kCancelled if Cancel was called before the last block of the last phase had ended; where that phase
  //   has no block, before it began.
  virtual void OnEnd(absl::Status status) = 0;

  // The most bytes that the job held at the beginning or the end of a phase so far. Asked for between blocks only.
  size_t peak_bytes() const { return peak_bytes_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Mark {
    std::string_view name;
    double began;  // seconds since started_
  };

  // Begins phases until one has blocks to run, or the job has ended.
  void RunNextPhases();
  // Returns whether the pool runs blocks of `phase` now; sets *status if the job must end.
  bool BeginPhase(Phase& phase, absl::Status* status);
  // Hands blocks [first, first + count) of `phase` to the pool.
  void Submit(Phase& phase, size_t first, size_t count);
  void RunBlock(Phase& phase, size_t block, int worker);
  void EndSubmission(Phase& phase);
  absl::Status EndPhase(Phase& phase);
  void Fail(absl::Status status) ABSL_LOCKS_EXCLUDED(failure_mutex_);
  // The error that the job has come to, or OK.
  absl::Status Failure(std::string_view phase) const ABSL_LOCKS_EXCLUDED(failure_mutex_);
  void Finish(absl::Status status);

  void MarkFirstBlock(const Phase& phase);
  void MarkPhase(std::string_view name) ABSL_LOCKS_EXCLUDED(times_mutex_);
  void NotePeak();
  double SecondsSinceStart() const;

  WorkerPool& pool_;
  const JobPriority priority_;
  const CallerKey caller_;
  const Clock::time_point started_;
  std::vector<std::unique_ptr<Phase>> phases_;
  size_t next_phase_ = 0;
  std::atomic<size_t> open_submissions_ = 0;  // of the phase that runs: handed to the pool, and not done
  std::atomic<bool> stopped_ = false;
  std::atomic<bool> cancelled_ = false;
  std::atomic<bool> ended_ = false;
  std::atomic<bool> block_began_ = false;
  size_t peak_bytes_ = 0;
  mutable Mutex failure_mutex_;
  absl::Status failure_ ABSL_GUARDED_BY(failure_mutex_);
  mutable Mutex times_mutex_;
  // A change of name each. AddPhase makes room for the phase's, so that marking it allocates nothing.
  std::vector<Mark> marks_ ABSL_GUARDED_BY(times_mutex_);
  double ended_after_ ABSL_GUARDED_BY(times_mutex_) = -1.0;
};

}  // namespace curvd
