#include "server/admission/memory_budget.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

constexpr absl::Duration kRetryAfter = absl::Seconds(1);

absl::Status Exhausted(const char* reason, std::string field, std::string value, std::string limit,
                       absl::Duration retry_after) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   {reason, std::move(field), std::move(value), std::move(limit), retry_after});
}

}  // namespace

uint64_t MemoryBudget::reserved() const {
  MutexLock lock(mutex_);
  return reserved_;
}

size_t MemoryBudget::waiting() const {
  MutexLock lock(mutex_);
  return growers_.size() + newcomers_.size();
}

bool MemoryBudget::CanServe(const Reservation& reservation) const {
  const bool nobody_before = growers_.empty() && (reservation.held_ > 0 || newcomers_.empty());
  return nobody_before && Fits(reservation.wanted_ - reservation.held_);
}

void MemoryBudget::Grant(Reservation& reservation) {
  if (reservation.held_ == 0) ++active_holders_;
  reserved_ += reservation.wanted_ - reservation.held_;
  reservation.held_ = reservation.wanted_;
}

absl::Status MemoryBudget::Enqueue(Reservation& reservation) {
  if (reservation.held_ == 0) {
    if (newcomers_.size() >= max_waiting_) {
      return Exhausted(kReasonQueueFull, "number of calls that wait for memory", absl::StrCat(newcomers_.size()),
                       absl::StrCat("below ", max_waiting_, " (max_waiting) for one more"), kRetryAfter);
    }
    newcomers_.push_back(&reservation);
    return absl::OkStatus();
  }
  if (active_holders_ == 1) {
    return Exhausted(kReasonMemoryBusy, "memory of this call", absl::StrCat(reservation.wanted_, " bytes"),
                     absl::StrCat("at most ", limit_ - reserved_ + reservation.held_,
                                  " bytes now, as all other calls wait for more (memory_limit); a header.point_count "
                                  "lets the call wait for its turn"),
                     kRetryAfter);
  }
  --active_holders_;
  growers_.push_back(&reservation);
  return absl::OkStatus();
}

MemoryBudget::Answers MemoryBudget::Serve() {
  Answers answers;
  while (!growers_.empty() && Fits(growers_.front()->wanted_ - growers_.front()->held_)) {
    Reservation& reservation = *growers_.front();
    growers_.pop_front();
    Grant(reservation);
    ++active_holders_;
    answers.push_back({std::exchange(reservation.answer_, nullptr), absl::OkStatus()});
  }
  while (growers_.empty() && !newcomers_.empty() && Fits(newcomers_.front()->wanted_)) {
    Reservation& reservation = *newcomers_.front();
    newcomers_.pop_front();
    Grant(reservation);
    answers.push_back({std::exchange(reservation.answer_, nullptr), absl::OkStatus()});
  }
  if (active_holders_ == 0 && !growers_.empty()) {
    Reservation& youngest = *growers_.back();
    growers_.pop_back();
    ++active_holders_;  // it still holds bytes, and will give them back
    answers.push_back({std::exchange(youngest.answer_, nullptr),
                       Exhausted(kReasonMemoryBusy, "memory of this call", absl::StrCat(youngest.wanted_, " bytes"),
                                 absl::StrCat("at most ", youngest.held_,
                                              " bytes now, as all other calls wait for more (memory_limit)"),
                                 kRetryAfter)});
  }
  return answers;
}

bool MemoryBudget::Forget(Reservation& reservation) {
  if (reservation.answer_ == nullptr) return false;
  reservation.answer_ = nullptr;
  if (reservation.held_ > 0) {
    std::erase(growers_, &reservation);
    ++active_holders_;
  } else {
    std::erase(newcomers_, &reservation);
  }
  return true;
}

void MemoryBudget::Give(Answers answers) {
  for (Answer& answer : answers) answer.callback(std::move(answer.status));
}

MemoryBudget::Reservation::~Reservation() {
  Abandon();
  ShrinkTo(0);
}

absl::StatusOr<bool> MemoryBudget::Reservation::GrowTo(uint64_t bytes, std::function<void(absl::Status)> answer) {
  MutexLock lock(budget_.mutex_);
  if (abandoned_) return absl::CancelledError("the call has ended");
  if (bytes <= held_) return true;
  if (bytes > budget_.limit_) {
    return Exhausted(kReasonMemoryLimit, "memory of this call", absl::StrCat(bytes, " bytes"),
                     absl::StrCat("at most ", budget_.limit_, " bytes (memory_limit)"), absl::ZeroDuration());
  }
  wanted_ = bytes;
  if (budget_.CanServe(*this)) {
    budget_.Grant(*this);
    return true;
  }
  if (absl::Status status = budget_.Enqueue(*this); !status.ok()) return status;
  answer_ = std::move(answer);
  return false;
}

void MemoryBudget::Reservation::ShrinkTo(uint64_t bytes) {
  Answers answers;
  {
    MutexLock lock(budget_.mutex_);
    if (bytes >= held_) return;
    budget_.reserved_ -= held_ - bytes;
    held_ = bytes;
    if (held_ == 0) --budget_.active_holders_;
    answers = budget_.Serve();
  }
  Give(std::move(answers));
}

void MemoryBudget::Reservation::Abandon() {
  Answers answers;
  {
    MutexLock lock(budget_.mutex_);
    abandoned_ = true;
    if (!budget_.Forget(*this)) return;
    answers = budget_.Serve();
  }
  Give(std::move(answers));
}

}  // namespace curvd
