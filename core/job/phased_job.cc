#include "core/job/phased_job.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/out_of_memory.h"

namespace curvd {
namespace {

absl::string_view ForAbsl(std::string_view text) { return {text.data(), text.size()}; }

}  // namespace

double SecondsOf(const std::vector<PhaseTime>& times, std::string_view name) {
  double seconds = 0.0;
  for (const PhaseTime& phase : times) seconds += phase.name == name ? phase.seconds : 0.0;
  return seconds;
}

PhasedJob::PhasedJob(WorkerPool& pool, JobPriority priority, CallerKey caller)
    : pool_(pool), priority_(priority), caller_(caller), started_(Clock::now()) {
  PrepareOutOfMemoryError();
  MutexLock lock(times_mutex_);
  marks_.push_back({kQueuePhase, 0.0});
}

void PhasedJob::Cancel() {
  cancelled_ = true;
  stopped_ = true;
}

std::vector<PhaseTime> PhasedJob::phase_times() const {
  std::vector<PhaseTime> times;
  VisitPhaseTimes([&times](const PhaseTime& phase) { times.push_back(phase); });
  return times;
}

void PhasedJob::VisitPhaseTimes(absl::FunctionRef<void(const PhaseTime&)> visit) const {
  MutexLock lock(times_mutex_);
  const double end = ended_after_ < 0.0 ? SecondsSinceStart() : ended_after_;
  for (size_t i = 0; i < marks_.size(); ++i) {
    visit({marks_[i].name, (i + 1 < marks_.size() ? marks_[i + 1].began : end) - marks_[i].began});
  }
}

void PhasedJob::AddPhase(std::unique_ptr<Phase> phase) {
  {
    // One mark for each phase, and the first one.
    MutexLock lock(times_mutex_);
    if (marks_.capacity() < phases_.size() + 2) marks_.reserve(2 * phases_.size() + 8);
  }
  phases_.push_back(std::move(phase));
}

void PhasedJob::Run(absl::Status status) { status.ok() ? RunNextPhases() : Finish(std::move(status)); }

void PhasedJob::RunNextPhases() {
  absl::Status status;
  while (status.ok() && next_phase_ < phases_.size()) {
    Phase& phase = *phases_[next_phase_++];
    if (status = Failure(phase.name()); !status.ok()) break;
    if (BeginPhase(phase, &status)) return;
  }
  Finish(std::move(status));
}

bool PhasedJob::BeginPhase(Phase& phase, absl::Status* status) {
  if (block_began_) MarkPhase(phase.name());
  const absl::StatusOr<size_t> blocks = CatchBadAlloc([&] { return phase.Begin(); });
  if (!blocks.ok()) {
    *status = blocks.status();
    return false;
  }
  NotePeak();
  if (*blocks == 0) {
    *status = EndPhase(phase);
    return false;
  }
  *status = CatchBadAlloc([&] {
    Submit(phase, 0, *blocks);
    return absl::OkStatus();
  });
  return status->ok();
}

void PhasedJob::Submit(Phase& phase, size_t first, size_t count) {
  const std::shared_ptr<PhasedJob> self = shared_from_this();
  ++open_submissions_;
  try {
    pool_.Submit(
        priority_, count,
        [self, &phase, first](size_t block, int worker) { self->RunBlock(phase, first + block, worker); },
        [self, &phase] { self->EndSubmission(phase); }, &stopped_, caller_);
  } catch (const std::bad_alloc&) {
    --open_submissions_;
    throw;
  }
}

void PhasedJob::RunBlock(Phase& phase, size_t block, int worker) {
  if (!block_began_) MarkFirstBlock(phase);
  if (stopped_) return;
  const auto add_block = [&](size_t added) { Submit(phase, added, 1); };
  absl::Status status = CatchBadAlloc([&] { return phase.RunBlock({block, worker, stopped_, add_block}); });
  if (!status.ok()) Fail(std::move(status));
}

void PhasedJob::EndSubmission(Phase& phase) {
  if (--open_submissions_ > 0) return;
  absl::Status status = Failure(phase.name());
  if (status.ok()) status = EndPhase(phase);
  status.ok() ? RunNextPhases() : Finish(std::move(status));
}

absl::Status PhasedJob::EndPhase(Phase& phase) {
  absl::Status status = CatchBadAlloc([&] { return phase.End(); });
  NotePeak();
  return status;
}

void PhasedJob::Fail(absl::Status status) {
  MutexLock lock(failure_mutex_);
  if (failure_.ok()) failure_ = std::move(status);
  stopped_ = true;
}

absl::Status PhasedJob::Failure(std::string_view phase) const {
  {
    MutexLock lock(failure_mutex_);
    if (!failure_.ok()) return failure_;
  }
  if (!cancelled_) return absl::OkStatus();
  return CatchBadAlloc([&] {
    return MakeCoreError(ErrorKind::kCancelled, absl::StrCat("cancelled in the phase \"", ForAbsl(phase), "\""));
  });
}

void PhasedJob::Finish(absl::Status status) {
  {
    MutexLock lock(times_mutex_);
    ended_after_ = SecondsSinceStart();
  }
  phases_.clear();
  ended_ = true;
  OnEnd(std::move(status));
}

void PhasedJob::MarkFirstBlock(const Phase& phase) {
  if (!block_began_.exchange(true)) MarkPhase(phase.name());
}

void PhasedJob::MarkPhase(std::string_view name) {
  MutexLock lock(times_mutex_);
  if (marks_.back().name != name) marks_.push_back({name, SecondsSinceStart()});
}

void PhasedJob::NotePeak() { peak_bytes_ = std::max(peak_bytes_, HeldBytes()); }

double PhasedJob::SecondsSinceStart() const { return std::chrono::duration<double>(Clock::now() - started_).count(); }

}  // namespace curvd
