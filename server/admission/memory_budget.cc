#include "server/admission/memory_budget.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "server/admission/passing_order.h"
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
  return growers_.size() + newcomers_;
}

void MemoryBudget::Tick() {
  Answers answers;
  {
    MutexLock lock(mutex_);
    if (newcomers_ == 0) return;
    answers = Serve(now_());
  }
  Give(std::move(answers));
}

bool MemoryBudget::Fits(const Reservation& reservation) const {
  return reserved_ + reservation.wanted_ - reservation.held_ <= limit_;
}

MemoryBudget::Account& MemoryBudget::Join(uint64_t caller, Clock::time_point now) {
  Account& account = accounts_[caller];
  if (account.reservations++ == 0) {
    account.used = std::max(account.used, level_);
    account.since = now;
  }
  return account;
}

void MemoryBudget::Settle(Account& account, Clock::time_point now) {
  // Nobody is charged while nobody waits: what others do not want costs nothing.
  if (AnyWaits()) {
    account.used += static_cast<double>(account.held) * std::chrono::duration<double>(now - account.since).count();
  }
  account.since = now;
}

void MemoryBudget::SettleAll(Clock::time_point now) {
  for (auto& [caller, account] : accounts_) Settle(account, now);
}

void MemoryBudget::Leave(uint64_t caller) {
  const auto found = accounts_.find(caller);
  if (--found->second.reservations == 0 && found->second.used <= level_) accounts_.erase(found);
}

void MemoryBudget::Enqueue(Reservation& reservation, Clock::time_point now) {
  if (!AnyWaits()) SettleAll(now);  // they are charged from now on
  reservation.arrival_ = ++arrivals_;
  reservation.waits_ = true;
  reservation.refusal_ = absl::OkStatus();
  if (reservation.held_ > 0) {
    --active_holders_;
    growers_.push_back(&reservation);
  } else {
    reservation.claim_.emplace(reservation.wanted_);
    Join(reservation.caller_, now).newcomers.push_back(&reservation);
    ++newcomers_;
  }
}

void MemoryBudget::Dequeue(Reservation& reservation) {
  reservation.waits_ = false;
  if (reservation.held_ > 0) {
    ++active_holders_;
    growers_.remove(&reservation);
  } else {
    accounts_[reservation.caller_].newcomers.remove(&reservation);
    --newcomers_;
    Leave(reservation.caller_);
  }
  if (AnyWaits()) return;
  level_ = 0.0;
  std::erase_if(accounts_, [](const auto& entry) { return entry.second.reservations == 0; });
  for (auto& [caller, account] : accounts_) account.used = 0.0;
}

void MemoryBudget::Grant(Reservation& reservation, Clock::time_point now) {
  if (reservation.held_ == 0) {
    ++active_holders_;
    Join(reservation.caller_, now);
  }
  Account& account = accounts_[reservation.caller_];
  const uint64_t added = reservation.wanted_ - reservation.held_;
  account.held += added;
  reserved_ += added;
  reservation.held_ = reservation.wanted_;
}

void MemoryBudget::Refuse(Reservation& reservation, absl::Status status, Answers& answers) {
  Dequeue(reservation);
  reservation.refusal_ = status;
  if (reservation.answer_ == nullptr) return;  // it is in GrowTo now
  answers.push_back({std::exchange(reservation.answer_, nullptr), std::move(status)});
}

bool MemoryBudget::IsBefore(const Reservation& a, const Reservation& b) const {
  const Account& of_a = accounts_.at(a.caller_);
  const Account& of_b = accounts_.at(b.caller_);
  if (of_a.used != of_b.used) return of_a.used < of_b.used;
  if (of_a.held != of_b.held) return of_a.held < of_b.held;
  return a.arrival_ < b.arrival_;
}

bool MemoryBudget::CanBeServed(const Reservation& reservation) const {
  return accounts_.at(reservation.caller_).held + reservation.wanted_ <= limit_;
}

std::vector<MemoryBudget::Reservation*> MemoryBudget::Heads() const {
  std::vector<Reservation*> heads;
  for (const auto& [caller, account] : accounts_) {
    if (!account.newcomers.empty()) heads.push_back(account.newcomers.front());
  }
  std::sort(heads.begin(), heads.end(),
            [this](const auto* a, const auto* b) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return IsBefore(*a, *b); });
  return heads;
}

bool MemoryBudget::ServeGrower(Clock::time_point now, Answers& answers) {
  Reservation* next = nullptr;
  for (Reservation* grower : growers_) {
    // Who is next keeps others waiting, unless all that hold memory wait: of those, one that fits goes on, which gives
    // memory back in the end, and nobody is refused.
    if (active_holders_ == 0 && !Fits(*grower)) continue;
    if (next == nullptr || IsBefore(*grower, *next)) next = grower;
  }
  if (next == nullptr || !Fits(*next)) return false;
  Reservation& reservation = *next;
  Dequeue(reservation);
  Grant(reservation, now);
  if (reservation.answer_ != nullptr) answers.push_back({std::exchange(reservation.answer_, nullptr), {}});
  return true;
}

bool MemoryBudget::ServeNewcomer(Clock::time_point now, Answers& answers) {
  const std::vector<Reservation*> heads = Heads();
  std::vector<WaitingHead> waiting;
  waiting.reserve(heads.size());
  for (Reservation* head : heads) waiting.push_back({&*head->claim_, head->arrival_, CanBeServed(*head)});
  PassingOrder order(std::move(waiting), now);
  for (size_t i = 0; i < heads.size(); ++i) {
    Reservation& next = *heads[i];
    if (!Fits(next) || !order.MayGo(i)) continue;
    for (size_t other = 0; other < heads.size(); ++other) {
      if (other != i && order.Overtakes(i, other)) heads[other]->claim_->CountPassed(next.wanted_);
    }
    level_ = std::max(level_, Join(next.caller_, now).used);  // so that its account outlives the place in the queue
    Dequeue(next);
    Grant(next, now);
    Leave(next.caller_);
    if (next.answer_ != nullptr) answers.push_back({std::exchange(next.answer_, nullptr), {}});
    return true;
  }
  return false;
}

void MemoryBudget::RefuseOneOfAllHolders(Answers& answers) {
  if (active_holders_ > 0 || growers_.empty()) return;
  Reservation& victim = **std::max_element(
      growers_.begin(), growers_.end(), [this](const auto* a, const auto* b) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        const uint64_t of_a = accounts_.at(a->caller_).held, of_b = accounts_.at(b->caller_).held;
        return of_a != of_b ? of_a < of_b : a->arrival_ < b->arrival_;
      });
  Refuse(victim,
         Exhausted(kReasonMemoryBusy, "memory of this call", absl::StrCat(victim.wanted_, " bytes"),
                   absl::StrCat("at most ", limit_ - reserved_ + victim.held_,
                                " bytes now, as all other calls wait for more (", limit_name_,
                                "); a header.point_count lets the call wait for its turn"),
                   kRetryAfter),
         answers);
}

void MemoryBudget::RefuseOneOfTooMany(Answers& answers) {
  if (newcomers_ <= max_waiting_) return;
  const auto most = std::max_element(accounts_.begin(), accounts_.end(), [](const auto& a, const auto& b) {
    const auto &of_a = a.second.newcomers, &of_b = b.second.newcomers;
    if (of_a.size() != of_b.size()) return of_a.size() < of_b.size();
    return !of_a.empty() && of_a.back()->arrival_ < of_b.back()->arrival_;
  });
  Refuse(*most->second.newcomers.back(),
         Exhausted(kReasonQueueFull, "number of calls that wait for memory", absl::StrCat(newcomers_ - 1),
                   absl::StrCat("below ", max_waiting_, " (max_waiting) for one more"), kRetryAfter),
         answers);
}

MemoryBudget::Answers MemoryBudget::Serve(Clock::time_point now) {
  SettleAll(now);
  Answers answers;
  while (ServeGrower(now, answers) || (growers_.empty() && ServeNewcomer(now, answers))) {
  }
  RefuseOneOfAllHolders(answers);
  RefuseOneOfTooMany(answers);
  return answers;
}

void MemoryBudget::Give(Answers answers) {
  for (Answer& answer : answers) answer.callback(std::move(answer.status));
}

MemoryBudget::Reservation::~Reservation() {
  Abandon();
  ShrinkTo(0);
}

absl::StatusOr<bool> MemoryBudget::Reservation::GrowTo(uint64_t bytes, uint64_t needed_now,
                                                       std::function<void(absl::Status)> answer) {
  Answers answers;
  absl::StatusOr<bool> granted = false;
  {
    MutexLock lock(budget_.mutex_);
    if (abandoned_) return absl::CancelledError("the call has ended");
    needed_ = needed_now;
    if (has_lent_) bytes = needed_now;
    if (bytes <= held_) return true;
    if (bytes > budget_.limit_) {
      return Exhausted(kReasonMemoryLimit, "memory of this call", absl::StrCat(bytes, " bytes"),
                       absl::StrCat("at most ", budget_.limit_, " bytes (", budget_.limit_name_, ")"),
                       absl::ZeroDuration());
    }
    wanted_ = bytes;
    const Clock::time_point now = budget_.now_();
    if (!budget_.AnyWaits() && budget_.Fits(*this)) {
      budget_.Grant(*this, now);
      return true;
    }
    budget_.Enqueue(*this, now);
    answers = budget_.Serve(now);
    if (waits_) {
      answer_ = std::move(answer);
    } else if (refusal_.ok()) {
      granted = true;
    } else {
      granted = refusal_;
    }
  }
  Give(std::move(answers));
  return granted;
}

MemoryBudget::Answers MemoryBudget::Reservation::Shrink(uint64_t bytes) {
  Account& account = budget_.accounts_[caller_];
  const Clock::time_point now = budget_.now_();
  budget_.Settle(account, now);
  budget_.reserved_ -= held_ - bytes;
  account.held -= held_ - bytes;
  held_ = bytes;
  if (held_ == 0) {
    --budget_.active_holders_;
    budget_.Leave(caller_);
  }
  return budget_.Serve(now);
}

void MemoryBudget::Reservation::ShrinkTo(uint64_t bytes) {
  Answers answers;
  {
    MutexLock lock(budget_.mutex_);
    if (bytes >= held_) return;
    answers = Shrink(bytes);
  }
  Give(std::move(answers));
}

void MemoryBudget::Reservation::Lend() {
  Answers answers;
  {
    MutexLock lock(budget_.mutex_);
    if (waits_ || needed_ >= held_ || !budget_.AnyWaits()) return;
    has_lent_ = true;
    answers = Shrink(needed_);
  }
  Give(std::move(answers));
}

void MemoryBudget::Reservation::Abandon() {
  Answers answers;
  {
    MutexLock lock(budget_.mutex_);
    abandoned_ = true;
    if (!waits_) return;
    budget_.Dequeue(*this);
    answer_ = nullptr;
    answers = budget_.Serve(budget_.now_());
  }
  Give(std::move(answers));
}

}  // namespace curvd
