#include "server/admission/memory_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <list>
#include <memory>
#include <thread>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

using Reservation = MemoryBudget::Reservation;
constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;

// Keeps the answer that a reservation gets.
struct Answer {
  std::function<void(absl::Status)> callback() {
    return [this](absl::Status answer) {
      ++count;
      status = std::move(answer);
    };
  }
  int count = 0;
  absl::Status status;
};

void MustNotAnswer(const absl::Status& status) { FAIL() << "unexpected answer: " << status; }

bool GrantsNow(Reservation& reservation, uint64_t bytes) {
  const absl::StatusOr<bool> granted = reservation.GrowTo(bytes, MustNotAnswer);
  return granted.ok() && *granted;
}

bool Waits(Reservation& reservation, uint64_t bytes, Answer& answer) {
  const absl::StatusOr<bool> granted = reservation.GrowTo(bytes, answer.callback());
  return granted.ok() && !*granted;
}

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
  Answer large_answer, small_answer;
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
  Answer answer;
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
  Answer first_answer, second_answer;
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
  Answer newcomer_answer, grower_answer;
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
  Answer answer;
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
  Answer answer;
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
  Answer first_answer, second_answer;
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

// A budget whose time stands still until it is moved.
class MemoryBudgetTurnsTest : public testing::Test {
 protected:
  static constexpr uint64_t kAlice = 1, kBob = 2, kCarol = 3;

  void Pass(MemoryBudget::Clock::duration time) {
    now_ += time;
    budget_.Tick();
  }
  std::unique_ptr<Reservation> Make(uint64_t caller) { return std::make_unique<Reservation>(budget_, caller); }
  // A reservation that was granted.
  std::unique_ptr<Reservation> Hold(uint64_t caller, uint64_t bytes) {
    auto reservation = Make(caller);
    EXPECT_TRUE(GrantsNow(*reservation, bytes));
    return reservation;
  }
  // A reservation that waits.
  std::unique_ptr<Reservation> Wait(uint64_t caller, uint64_t bytes, Answer& answer) {
    auto reservation = Make(caller);
    EXPECT_TRUE(Waits(*reservation, bytes, answer));
    return reservation;
  }

  MemoryBudget::Clock::time_point now_;
  MemoryBudget budget_{100, 6, [this] { return now_; }};
};

TEST_F(MemoryBudgetTurnsTest, WhoHoldsNothingGoesBeforeTheOtherCallsOfWhoHoldsAll) {
  auto first = Hold(kAlice, 50), second = Hold(kAlice, 50);
  Answer alice, bob;
  auto third = Wait(kAlice, 50, alice);
  auto other = Wait(kBob, 50, bob);
  Pass(std::chrono::seconds(1));
  first.reset();
  EXPECT_EQ(bob.count, 1);
  EXPECT_EQ(alice.count, 0);
  second.reset();
  EXPECT_EQ(alice.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, TurnsAreWeightedByBytesAndTime) {
  auto full = Hold(kCarol, 100);
  Answer answers[4];
  auto alice = Wait(kAlice, 60, answers[0]);
  auto bob = Wait(kBob, 40, answers[1]);
  auto alice_again = Wait(kAlice, 10, answers[2]);
  auto bob_again = Wait(kBob, 10, answers[3]);
  full.reset();
  ASSERT_EQ(answers[0].count + answers[1].count, 2);
  Pass(std::chrono::seconds(1));
  bob.reset();
  EXPECT_EQ(answers[3].count, 1) << "bob has had 40 byte seconds, alice 60";
  EXPECT_EQ(answers[2].count, 1) << "and both fit";
  alice_again.reset();
  bob_again.reset();
  alice.reset();
  EXPECT_EQ(budget_.reserved(), 0u);
}

TEST_F(MemoryBudgetTurnsTest, ASmallCallOfAnotherPassesALargeOneThatWaits) {
  auto holder = Hold(kAlice, 20);
  Answer large;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(GrantsNow(*Make(kBob), 20)) << i;
  holder.reset();
  EXPECT_EQ(large.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, ALargeCallIsPassedByAsManyBytesAsItWantsAtFirst) {
  auto holder = Hold(kAlice, 20);
  Answer large, small;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 5; ++i) Hold(kBob, 20);
  auto late = Wait(kBob, 20, small);
  holder.reset();
  EXPECT_EQ(large.count, 1);
  EXPECT_EQ(small.count, 0);
  waiting.reset();
  EXPECT_EQ(small.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, AClaimThatCannotBeServedLetsOthersPassAfterAWhile) {
  auto holder = Hold(kAlice, 20);
  Answer large, small, later;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 5; ++i) Hold(kBob, 20);
  auto late = Wait(kBob, 20, small);
  Pass(WaitingClaim::kFirstClaim - std::chrono::milliseconds(1));
  EXPECT_EQ(small.count, 0);
  Pass(std::chrono::milliseconds(1));
  EXPECT_EQ(small.count, 1) << "it was served as time went by";
  for (int i = 0; i < 20; ++i) Hold(kBob, 20);
  Pass(WaitingClaim::kFirstClaim);
  auto last = Wait(kBob, 20, later);
  Pass(2 * WaitingClaim::kFirstClaim - std::chrono::milliseconds(1));
  EXPECT_EQ(later.count, 0) << "the second claim lasts twice as long";
  Pass(std::chrono::milliseconds(1));
  EXPECT_EQ(later.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, ACallThatItsOwnCallerKeepsWaitingKeepsNobodyElseWaiting) {
  auto holder = Hold(kCarol, 20);
  Answer large;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(GrantsNow(*Make(kBob), 20)) << i;
  EXPECT_EQ(large.count, 0);
}

TEST_F(MemoryBudgetTurnsTest, NobodyStarvesBesideAStreamOfSmallCalls) {
  Answer large;
  std::list<Answer> answers;  // outlive the reservations, which may still answer
  std::vector<std::unique_ptr<Reservation>> small;
  for (uint64_t caller = 10; caller < 15; ++caller) small.push_back(Hold(caller, 20));
  auto waiting = Wait(kCarol, 100, large);
  // Each small call ends after a second, and its caller makes another.
  for (int i = 0; i < 200 && large.count == 0; ++i) {
    auto& call = small[i % small.size()];
    call = Make(10 + i % small.size());
    answers.emplace_back();
    ASSERT_TRUE(call->GrowTo(20, answers.back().callback()).ok());
    Pass(std::chrono::milliseconds(200));
  }
  EXPECT_EQ(large.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, WhoComesLateHasNoMoreRightThanThoseWhoWereServed) {
  // Carol waits for her own call, so that somebody waits all the time.
  auto carols = Hold(kCarol, 1);
  Answer carol, alice[2], bob[2];
  auto waiting = Wait(kCarol, 100, carol);
  auto first = Hold(kAlice, 99);
  auto second = Wait(kAlice, 99, alice[0]);
  Pass(std::chrono::hours(1));
  first.reset();
  ASSERT_EQ(alice[0].count, 1);
  auto third = Wait(kAlice, 99, alice[1]);
  auto bobs = Wait(kBob, 51, bob[0]);
  Pass(std::chrono::seconds(1));
  second.reset();
  ASSERT_EQ(bob[0].count, 1) << "alice has had a second more since bob came";
  auto bobs_next = Wait(kBob, 51, bob[1]);
  Pass(std::chrono::seconds(3));
  bobs.reset();
  EXPECT_EQ(alice[1].count, 1) << "and not only after an hour of bob's";
  EXPECT_EQ(bob[1].count, 0);
}

TEST_F(MemoryBudgetTurnsTest, WhoIsServedKeepsWhatItHasHad) {
  // Dave waits for his own call, so that somebody waits all the time.
  constexpr uint64_t kDave = 4;
  auto daves = Hold(kDave, 1), alices = Hold(kAlice, 39);
  Answer dave, carol[2], alice;
  auto waiting = Wait(kDave, 100, dave);
  auto carols = Wait(kCarol, 99, carol[0]);
  auto bobs = Hold(kBob, 50);
  Pass(std::chrono::seconds(4));
  bobs.reset();
  Hold(kBob, 40);  // bob had 200 byte seconds when he was served
  alices.reset();
  ASSERT_EQ(carol[0].count, 1);
  auto alices_next = Wait(kAlice, 60, alice);
  auto carols_next = Wait(kCarol, 60, carol[1]);
  Pass(std::chrono::seconds(1));
  carols.reset();
  EXPECT_EQ(carol[1].count, 1) << "carol has had 99 byte seconds, and whoever comes begins with 200";
  EXPECT_EQ(alice.count, 0);
}

TEST(MemoryBudgetTest, ReadsTheClockOnceHoweverManyWait) {
  int reads = 0;
  MemoryBudget budget(1'000, 200, [&reads] {
    ++reads;
    return MemoryBudget::Clock::time_point();
  });
  Reservation holder(budget, 0);
  ASSERT_TRUE(GrantsNow(holder, 1'000));
  std::list<Answer> answers;
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
  for (const Answer& answer : answers) EXPECT_EQ(answer.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, OfTwoClaimsTheEarlierIsServed) {
  constexpr uint64_t kDave = 4;
  auto holder = Hold(kAlice, 30), of_bob = Hold(kBob, 10);
  Answer bob, carol, dave;
  auto came_first = Wait(kBob, 80, bob);
  auto has_turn = Wait(kCarol, 80, carol);
  for (int i = 0; i < 2; ++i) Hold(kDave, 40);
  auto late = Wait(kDave, 40, dave);
  EXPECT_EQ(dave.count, 0) << "they claim what is free";
  holder.reset();
  EXPECT_EQ(carol.count, 1);
  EXPECT_EQ(bob.count, 0);
}

TEST_F(MemoryBudgetTurnsTest, APlaceInTheQueueGoesFromWhoHasMost) {
  auto holder = Hold(kAlice, 100);
  Answer alice[6], bob[3];
  std::vector<std::unique_ptr<Reservation>> waiting;
  for (Answer& answer : alice) waiting.push_back(Wait(kAlice, 10, answer));
  EXPECT_TRUE(IsError(Make(kAlice)->GrowTo(10, MustNotAnswer).status(), kExhausted, kReasonQueueFull, {}))
      << "not at the cost of her own";
  for (int i = 0; i < 3; ++i) {
    waiting.push_back(Wait(kBob, 10, bob[i]));
    ASSERT_EQ(alice[5 - i].count, 1) << "her youngest";
    EXPECT_TRUE(IsError(alice[5 - i].status, kExhausted, kReasonQueueFull, {"6", "max_waiting"}));
  }
  EXPECT_TRUE(IsError(Make(kBob)->GrowTo(10, MustNotAnswer).status(), kExhausted, kReasonQueueFull, {}))
      << "both have three places now";
  EXPECT_EQ(budget_.waiting(), 6u);
}

TEST_F(MemoryBudgetTurnsTest, IfAllHoldersWaitTheOneWhoHoldsMostLoses) {
  auto first = Hold(kAlice, 40), second = Hold(kAlice, 40), other = Hold(kBob, 20);
  Answer answers[2];
  ASSERT_TRUE(Waits(*first, 50, answers[0]));
  ASSERT_TRUE(Waits(*second, 50, answers[1]));
  Answer bob;
  EXPECT_TRUE(Waits(*other, 30, bob));
  ASSERT_EQ(answers[1].count, 1);
  EXPECT_TRUE(IsError(answers[1].status, kExhausted, kReasonMemoryBusy, {"50 bytes", "memory_limit"}));
  second.reset();
  EXPECT_EQ(bob.count, 1);
  EXPECT_TRUE(bob.status.ok());
}

TEST_F(MemoryBudgetTurnsTest, TellsWhoHoldsMemoryWhetherItIsMissed) {
  auto holder = Hold(kAlice, 60);
  EXPECT_FALSE(holder->IsMissed());
  Answer answer;
  auto waiting = Wait(kBob, 60, answer);
  EXPECT_TRUE(holder->IsMissed());
  holder->ShrinkTo(20);
  EXPECT_EQ(answer.count, 1);
  EXPECT_FALSE(holder->IsMissed());
}

TEST_F(MemoryBudgetTurnsTest, LendsWhatIsNotNeededNowToThoseWhoWait) {
  auto holder = Make(kAlice);
  ASSERT_TRUE(*holder->GrowTo(90, 10, MustNotAnswer));
  holder->Lend();
  EXPECT_EQ(budget_.reserved(), 90u) << "nobody waits";
  Answer bob;
  auto waiting = Wait(kBob, 60, bob);
  holder->Lend();
  EXPECT_EQ(bob.count, 1);
  EXPECT_EQ(budget_.reserved(), 70u);
}

TEST_F(MemoryBudgetTurnsTest, WhoHasLentGrowsOnlyAsItNeedsAndWaitsForItsTurn) {
  auto holder = Make(kAlice);
  ASSERT_TRUE(*holder->GrowTo(90, 10, MustNotAnswer));
  Answer bob, alice;
  auto other = Wait(kBob, 60, bob);
  holder->Lend();
  ASSERT_TRUE(*holder->GrowTo(90, 40, MustNotAnswer));
  EXPECT_EQ(budget_.reserved(), 100u);
  EXPECT_FALSE(*holder->GrowTo(90, 50, alice.callback()));
  other.reset();
  EXPECT_EQ(alice.count, 1);
  EXPECT_EQ(budget_.reserved(), 50u);
  EXPECT_TRUE(*holder->GrowTo(90, 90, MustNotAnswer)) << "all of it is needed at last";
}

TEST_F(MemoryBudgetTurnsTest, WhoNeedsAllThatItHoldsLendsNothing) {
  auto holder = Hold(kAlice, 90);
  Answer bob;
  auto waiting = Wait(kBob, 60, bob);
  holder->Lend();
  EXPECT_EQ(bob.count, 0);
  EXPECT_EQ(budget_.reserved(), 90u);
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
