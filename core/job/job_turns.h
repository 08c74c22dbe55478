// Decides whose block runs next: callers take turns by what their blocks cost, and the jobs of a caller take turns too.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <set>
#include <unordered_map>

namespace curvd {

// Blocks of interactive jobs go before blocks of batch jobs, as far as JobTurns can be fair to both.
enum class JobPriority : uint8_t { kInteractive, kBatch };

// Stands for the one for whom a job runs. Jobs with the same key share their turns. 0 is nobody in particular, who is
// treated like any other caller.
using CallerKey = uint64_t;

// The order in which a pool runs the blocks of its jobs.
//
// Between callers: each caller has a clock that moves on by the worker time that its blocks took. The caller whose
// clock is furthest behind has the next turn; while it has interactive work, its clock counts as kInteractiveLead
// behind what it shows. Clocks that are level take turns. A caller who comes with its first job begins at the clock
// that had the last turn, so that nobody saves up turns by being idle, and a caller who comes back keeps what it has
// had beyond that. So among callers who always have work each gets the same share of the workers, however many jobs it
// has and however long its blocks are; one who wants little waits for about one block of the others; and work of one
// caller is held up by the interactive work of another by at most kInteractiveLead. Once no job is open, all clocks are
// level.
//
// Between jobs of a caller: interactive jobs go before batch jobs, save that every eighth turn is a batch job's. Jobs
// of equal priority take turns block by block.
//
// Everything takes O(log n) time for n callers with open jobs; only Add allocates memory. Measures no time itself. Not
// thread-safe.
class JobTurns {
 public:
  using Duration = std::chrono::nanoseconds;

  // Worker time by which interactive work goes ahead of what other callers have waiting.
  static constexpr Duration kInteractiveLead = std::chrono::milliseconds(20);
  // What the first block of a job is taken to cost until it has ended. A later one is taken to cost what the block
  // cost that ended last.
  static constexpr Duration kFirstGuess = std::chrono::milliseconds(1);
  // One turn in so many belongs to the batch jobs of a caller that has interactive ones too.
  static constexpr uint32_t kBatchTurn = 8;

  // A job as this class sees it.
  class Job {
   public:
    // REQUIRES: block_count >= 1; *stop lives as long as the job, if there is a stop.
    Job(CallerKey caller, JobPriority priority, size_t block_count, const std::atomic<bool>* stop)
        : caller_(caller), priority_(priority), block_count_(block_count), stop_(stop) {}

   private:
    friend class JobTurns;
    bool is_stopped() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }

    const CallerKey caller_;
    const JobPriority priority_;
    const size_t block_count_;
    const std::atomic<bool>* const stop_;
    size_t next_block_ = 0;
    size_t ended_blocks_ = 0;
    Duration expected_ = kFirstGuess;  // cost of a block
  };

  // Leave to run block `block` of `job`.
  struct Turn {
    Job* job;
    size_t block;
    size_t block_count;  // 1; or, if the job is stopped, all blocks that are left: none of them is to be run
    bool is_stopped;
    Duration charged;  // to the caller in advance
  };

  // Puts a job into the order. If this throws std::bad_alloc, the job was not added.
  // REQUIRES: `job` lives until Close.
  void Add(Job& job);

  // The next turn, or nothing if all blocks have been handed out. Once the stop of a job is true, its next turn takes
  // all blocks that are left.
  std::optional<Turn> Next();

  // The turn is over; its block took `took`. Returns whether it was the last one of its job. For a stopped turn `took`
  // is 0.
  bool End(const Turn& turn, Duration took);

  // Takes a job out, whose last turn has ended. A caller has work as long as it has a job that is not closed: what it
  // adds before it closes the last one goes on where it was.
  void Close(const Job& job);

  // Jobs with blocks that have not been handed out.
  size_t waiting_count() const { return waiting_; }
  // Jobs that have not been closed.
  size_t open_count() const { return open_; }
  // Callers that are remembered: those with open jobs, and those that have had more than others with open jobs.
  size_t caller_count() const { return callers_.size(); }

 private:
  struct Caller;
  struct Place {
    Duration clock{};
    uint64_t order = 0;  // breaks ties: who has waited longer goes first
    Caller* caller = nullptr;
    bool operator<(const Place& other) const {
      return clock != other.clock ? clock < other.clock : order < other.order;
    }
  };
  using Places = std::set<Place>;
  enum class Kept : uint8_t { kHere, kReady, kIdle };
  struct Caller {
    explicit Caller(CallerKey caller_key);
    const CallerKey key;
    Duration clock{};
    std::list<Job*> interactive;
    std::list<Job*> batch;
    uint32_t turn = 0;
    size_t open_jobs = 0;
    // The caller's node of ready_ or idle_ moves between them, so that only Add allocates.
    Kept kept = Kept::kHere;
    Places::node_type node;    // while kept here
    Places::iterator place{};  // while kept in ready_ or idle_
  };

  static Duration ClockOf(const Caller& caller);
  static std::list<Job*>& NextList(Caller& caller);
  void Move(Caller& caller, Kept to);
  void PlaceReady(Caller& caller);
  void ForgetLevelCallers();

  std::unordered_map<CallerKey, Caller> callers_;
  Places ready_;    // callers with blocks to hand out, by when their turn is
  Places idle_;     // callers without open jobs, by their clock
  Duration now_{};  // of the latest turn
  uint64_t order_ = 0;
  size_t waiting_ = 0;
  size_t open_ = 0;
};

}  // namespace curvd
