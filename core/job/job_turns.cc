#include "core/job/job_turns.h"

#include <algorithm>
#include <utility>

namespace curvd {

JobTurns::Caller::Caller(CallerKey caller_key) : key(caller_key) {
  Places places;
  places.insert(Place{});
  node = places.extract(places.begin());
}

JobTurns::Duration JobTurns::ClockOf(const Caller& caller) {
  return caller.interactive.empty() ? caller.clock : caller.clock - kInteractiveLead;
}

std::list<JobTurns::Job*>& JobTurns::NextList(Caller& caller) {
  if (caller.interactive.empty()) return caller.batch;
  if (caller.batch.empty()) return caller.interactive;
  return ++caller.turn % kBatchTurn == 0 ? caller.batch : caller.interactive;
}

void JobTurns::Move(Caller& caller, Kept to) {
  if (caller.kept == Kept::kReady) caller.node = ready_.extract(caller.place);
  if (caller.kept == Kept::kIdle) caller.node = idle_.extract(caller.place);
  caller.kept = to;
  if (to == Kept::kHere) return;
  caller.node.value() = {to == Kept::kReady ? ClockOf(caller) : caller.clock, ++order_, &caller};
  caller.place = (to == Kept::kReady ? ready_ : idle_).insert(std::move(caller.node)).position;
}

void JobTurns::PlaceReady(Caller& caller) {
  Move(caller, caller.interactive.empty() && caller.batch.empty() ? Kept::kHere : Kept::kReady);
}

void JobTurns::Add(Job& job) {
  std::list<Job*> added{&job};
  Caller& caller = callers_.try_emplace(job.caller_, job.caller_).first->second;
  if (caller.open_jobs == 0) caller.clock = std::max(caller.clock, now_);
  ++caller.open_jobs;
  auto& list = job.priority_ == JobPriority::kInteractive ? caller.interactive : caller.batch;
  list.splice(list.end(), added);
  ++waiting_;
  ++open_;
  PlaceReady(caller);
}

std::optional<JobTurns::Turn> JobTurns::Next() {
  if (ready_.empty()) return std::nullopt;
  Caller& caller = *ready_.begin()->caller;
  now_ = std::max(now_, ready_.begin()->clock);
  std::list<Job*>& list = NextList(caller);
  Job& job = *list.front();
  Turn turn{&job, job.next_block_, 1, job.is_stopped(), {}};
  if (turn.is_stopped) {
    turn.block_count = job.block_count_ - job.next_block_;
  } else {
    turn.charged = job.expected_;
  }
  job.next_block_ += turn.block_count;
  if (job.next_block_ < job.block_count_) {
    list.splice(list.end(), list, list.begin());  // jobs take turns
  } else {
    list.pop_front();
    --waiting_;
  }
  caller.clock += turn.charged;
  PlaceReady(caller);
  ForgetLevelCallers();
  return turn;
}

bool JobTurns::End(const Turn& turn, Duration took) {
  Job& job = *turn.job;
  Caller& caller = callers_.find(job.caller_)->second;
  caller.clock += took - turn.charged;
  if (!turn.is_stopped) job.expected_ = took;
  if (caller.kept == Kept::kReady) PlaceReady(caller);
  job.ended_blocks_ += turn.block_count;
  return job.ended_blocks_ == job.block_count_;
}

void JobTurns::Close(const Job& job) {
  Caller& caller = callers_.find(job.caller_)->second;
  --open_;
  --caller.open_jobs;
  if (open_ == 0) {
    // Nobody waits for anybody: whoever comes next has the same right as everyone.
    idle_.clear();
    callers_.clear();
    now_ = {};
  } else if (caller.open_jobs == 0) {
    Move(caller, Kept::kIdle);
    ForgetLevelCallers();
  }
}

void JobTurns::ForgetLevelCallers() {
  while (!idle_.empty() && idle_.begin()->clock <= now_) {
    const CallerKey key = idle_.begin()->caller->key;
    idle_.erase(idle_.begin());
    callers_.erase(key);
  }
}

}  // namespace curvd
