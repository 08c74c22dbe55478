#include "server/admission/memory_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <future>
#include <list>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/server/admission/reservations.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

using Reservation = MemoryBudget::Reservation;
constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;

TEST(MemoryBudgetTest, GrantsWhatIsFreeAndTakesItBack) {
  MemoryBudget budget(100, 10);
  {
    Reservation reservation(budget);
    EXPECT_TRUE(GrantsNow(reservation, 60));
    EXPECT_TRUE(GrantsNow(reservation, 100));
    EXPECT_EQ(budget.reserved(), 100u);
    EXPECT_TRUE(GrantsNow(reservation, 50)) << "growing to less than it holds changes nothing";
    EXPECT_EQ(budget.reserved(), 100u);
    reservation.ShrinkTo(30);
    EXPECT_EQ(budget.reserved(), 30u);
  }
  EXPECT_EQ(budget.reserved(), 0u);
}

TEST(MemoryBudgetTest, RefusesWhatCouldNeverFit) {
  MemoryBudget budget(100, 10);
  Reservation reservation(budget);
  EXPECT_TRUE(IsError(reservation.GrowTo(101, MustNotAnswer).status(), kExhausted, kReasonMemoryLimit,
                      {"101", "100", "memory_limit"}));
}

TEST(MemoryBudgetTest, ServesTheCallsOfACallerInTheOrderOfArrival) {
  MemoryBudget budget(100, 10);
  auto holder = std::make_unique<Reservation>(budget);
  ASSERT_TRUE(GrantsNow(*holder, 80));
  Reservation large(budget);
  Reservation small(budget);
  GrantAnswer large_answer, small_answer;
  EXPECT_TRUE(Waits(large, 90, large_answer));
  EXPECT_TRUE(Waits(small, 10, small_answer)) << "must not overtake, though it would fit";
  EXPECT_EQ(budget.waiting(), 2u);
  holder.reset();
  EXPECT_EQ(large_answer.count, 1);
  EXPECT_EQ(small_answer.count, 1);
  EXPECT_EQ(budget.reserved(), 100u);
  EXPECT_EQ(budget.waiting(), 0u);
}

TEST(MemoryBudgetTest, RefusesWhenTheQueueIsFull) {
  MemoryBudget budget(100, 1);
  Reservation holder(budget), first(budget), second(budget);
  GrantAnswer answer;
  ASSERT_TRUE(GrantsNow(holder, 100));
  ASSERT_TRUE(Waits(first, 10, answer));
  const absl::Status refusal = second.GrowTo(10, MustNotAnswer).status();
  EXPECT_TRUE(IsError(refusal, kExhausted, kReasonQueueFull, {"wait", "1", "max_waiting"}));
  EXPECT_TRUE(refusal.GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());
}

TEST(MemoryBudgetTest, AnAbandonedPlaceIsNotServed) {
  MemoryBudget budget(100, 10);
  auto holder = std::make_unique<Reservation>(budget);
  Reservation first(budget), second(budget);
  GrantAnswer first_answer, second_answer;
  ASSERT_TRUE(GrantsNow(*holder, 60));
  ASSERT_TRUE(Waits(first, 100, first_answer));
  ASSERT_TRUE(Waits(second, 40, second_answer));
  first.Abandon();
  EXPECT_EQ(second_answer.count, 1) << "the one behind moves up at once";
  holder.reset();
  EXPECT_EQ(first_answer.count, 0);
}

TEST(MemoryBudgetTest, WhoeverLeftNeverWaitsAgain) {
  MemoryBudget budget(100, 10);
  Reservation first(budget), second(budget);
  ASSERT_TRUE(GrantsNow(first, 80));
  second.Abandon();
  EXPECT_TRUE(absl::IsCancelled(second.GrowTo(50, MustNotAnswer).status()));
  EXPECT_EQ(budget.waiting(), 0u);
  first.ShrinkTo(0);
  EXPECT_EQ(budget.reserved(), 0u);
}

TEST(MemoryBudgetTest, ThoseWhoHoldBytesGoFirst) {
  MemoryBudget budget(100, 10);
  auto active = std::make_unique<Reservation>(budget);
  Reservation newcomer(budget), grower(budget);
  GrantAnswer newcomer_answer, grower_answer;
  ASSERT_TRUE(GrantsNow(*active, 50));
  ASSERT_TRUE(GrantsNow(grower, 40));
  ASSERT_TRUE(Waits(newcomer, 60, newcomer_answer));
  ASSERT_TRUE(Waits(grower, 70, grower_answer));
  active.reset();
  EXPECT_EQ(grower_answer.count, 1);
  EXPECT_EQ(newcomer_answer.count, 0);
  grower.ShrinkTo(0);
  EXPECT_EQ(newcomer_answer.count, 1);
}

TEST(MemoryBudgetTest, RefusesTheOneWhoWouldMakeAllHoldersWait) {
  MemoryBudget budget(100, 10);
  Reservation first(budget), second(budget);
  GrantAnswer answer;
  ASSERT_TRUE(GrantsNow(first, 50));
  ASSERT_TRUE(GrantsNow(second, 50));
  ASSERT_TRUE(Waits(first, 60, answer));
  const absl::Status refusal = second.GrowTo(60, MustNotAnswer).status();
  EXPECT_TRUE(IsError(refusal, kExhausted, kReasonMemoryBusy, {"60 bytes", "50 bytes", "memory_limit"}));
  second.ShrinkTo(0);
  EXPECT_EQ(answer.count, 1);
  EXPECT_TRUE(answer.status.ok());
}

TEST(MemoryBudgetTest, OneThatFitsGoesOnWhereAllHoldersWait) {
  MemoryBudget budget(100, 10);
  auto first = std::make_unique<Reservation>(budget);
  Reservation second(budget);
  GrantAnswer answer;
  ASSERT_TRUE(GrantsNow(*first, 50));
  ASSERT_TRUE(GrantsNow(second, 40));
  ASSERT_TRUE(Waits(*first, 100, answer));
  EXPECT_TRUE(GrantsNow(second, 50)) << "though it came later, and the first one waits for more";
  EXPECT_EQ(answer.count, 0);
  second.ShrinkTo(0);
  EXPECT_EQ(answer.count, 1);
  EXPECT_TRUE(answer.status.ok());
}

TEST(MemoryBudgetTest, RefusesTheYoungestWhenTheLastActiveHolderLeftTooLittle) {
  MemoryBudget budget(100, 10);
  auto active = std::make_unique<Reservation>(budget);
  Reservation first(budget), second(budget);
  GrantAnswer first_answer, second_answer;
  ASSERT_TRUE(GrantsNow(*active, 10));
  ASSERT_TRUE(GrantsNow(first, 45));
  ASSERT_TRUE(GrantsNow(second, 45));
  ASSERT_TRUE(Waits(first, 80, first_answer));
  ASSERT_TRUE(Waits(second, 80, second_answer));
  active.reset();
  EXPECT_EQ(first_answer.count, 0);
  ASSERT_EQ(second_answer.count, 1);
  EXPECT_TRUE(IsError(second_answer.status, kExhausted, kReasonMemoryBusy, {"80 bytes", "55 bytes"}));
  second.ShrinkTo(0);
  EXPECT_EQ(first_answer.count, 1);
  EXPECT_TRUE(first_answer.status.ok());
}

TEST(MemoryBudgetTest, AnswersMayUseTheBudget) {
  MemoryBudget budget(100, 10);
  auto holder = std::make_unique<Reservation>(budget);
  Reservation waiter(budget);
  ASSERT_TRUE(GrantsNow(*holder, 100));
  uint64_t seen = 0;
  ASSERT_FALSE(*waiter.GrowTo(10, [&](const absl::Status&) { seen = budget.reserved(); }));
  holder.reset();
  EXPECT_EQ(seen, 10u);
}

TEST(MemoryBudgetTest, ReadsTheClockOnceHoweverManyWait) {
  int reads = 0;
  MemoryBudget budget(1'000, 200, [&reads] {
    ++reads;
    return MemoryBudget::Clock::time_point();
  });
  Reservation holder(budget, 0);
  ASSERT_TRUE(GrantsNow(holder, 1'000));
  std::list<GrantAnswer> answers;
  std::list<Reservation> waiting;
  for (uint64_t caller = 1; caller <= 100; ++caller) {
    answers.emplace_back();
    waiting.emplace_back(budget, caller);
    ASSERT_TRUE(Waits(waiting.back(), 10, answers.back()));
  }
  reads = 0;
  budget.Tick();
  EXPECT_EQ(reads, 1);
  reads = 0;
  holder.ShrinkTo(0);
  EXPECT_EQ(reads, 1);
  for (const GrantAnswer& answer : answers) EXPECT_EQ(answer.count, 1);
}

TEST(MemoryBudgetTest, ManyThreadsNeverExceedTheLimitAndAllGetTheirTurn) {
  constexpr uint64_t kLimit = 1000;
  MemoryBudget budget(kLimit, 1000);
  std::atomic<uint64_t> in_use{0};
  std::atomic<int> served{0};
  const auto work = [&](int seed) {
    for (int i = 0; i < 300; ++i) {
      const uint64_t bytes = 1 + static_cast<uint64_t>((seed * 131 + i * 17) % 600);
      Reservation reservation(budget, seed % 3);
      const auto granted = std::make_shared<std::promise<absl::Status>>();
      const absl::StatusOr<bool> now =
          reservation.GrowTo(bytes, [granted](absl::Status status) { granted->set_value(std::move(status)); });
      ASSERT_TRUE(now.ok()) << now.status();
      if (!*now) {
        ASSERT_TRUE(granted->get_future().get().ok());
      }
      EXPECT_LE(in_use += bytes, kLimit);
      in_use -= bytes;
      ++served;
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(8);
  for (int t = 0; t < 8; ++t) threads.emplace_back(work, t);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(served, 8 * 300);
  EXPECT_EQ(budget.reserved(), 0u);
}

}  // namespace
}  // namespace curvd
