// Who is served first by a MemoryBudget for which several callers wait.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "server/admission/memory_budget.h"
#include "server/admission/waiting_claim.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/admission/reservations.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

// A budget whose time stands still until it is moved.
class MemoryBudgetTurnsTest : public testing::Test {
 protected:
  using Reservation = MemoryBudget::Reservation;
  static constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;
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
  std::unique_ptr<Reservation> Wait(uint64_t caller, uint64_t bytes, GrantAnswer& answer) {
    auto reservation = Make(caller);
    EXPECT_TRUE(Waits(*reservation, bytes, answer));
    return reservation;
  }

  MemoryBudget::Clock::time_point now_;
  MemoryBudget budget_{100, 6, [this] { return now_; }};
};

TEST_F(MemoryBudgetTurnsTest, WhoHoldsNothingGoesBeforeTheOtherCallsOfWhoHoldsAll) {
  auto first = Hold(kAlice, 50), second = Hold(kAlice, 50);
  GrantAnswer alice, bob;
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
  GrantAnswer answers[4];
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
  GrantAnswer large;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(GrantsNow(*Make(kBob), 20)) << i;
  holder.reset();
  EXPECT_EQ(large.count, 1);
}

TEST_F(MemoryBudgetTurnsTest, ALargeCallIsPassedByAsManyBytesAsItWantsAtFirst) {
  auto holder = Hold(kAlice, 20);
  GrantAnswer large, small;
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
  GrantAnswer large, small, later;
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
  GrantAnswer large;
  auto waiting = Wait(kCarol, 100, large);
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(GrantsNow(*Make(kBob), 20)) << i;
  EXPECT_EQ(large.count, 0);
}

TEST_F(MemoryBudgetTurnsTest, NobodyStarvesBesideAStreamOfSmallCalls) {
  GrantAnswer large;
  std::list<GrantAnswer> answers;  // outlive the reservations, which may still answer
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
  GrantAnswer carol, alice[2], bob[2];
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
  GrantAnswer dave, carol[2], alice;
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

TEST_F(MemoryBudgetTurnsTest, OfTwoClaimsTheEarlierIsServed) {
  constexpr uint64_t kDave = 4;
  auto holder = Hold(kAlice, 30), of_bob = Hold(kBob, 10);
  GrantAnswer bob, carol, dave;
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
  GrantAnswer alice[6], bob[3];
  std::vector<std::unique_ptr<Reservation>> waiting;
  for (GrantAnswer& answer : alice) waiting.push_back(Wait(kAlice, 10, answer));
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
  GrantAnswer answers[2];
  ASSERT_TRUE(Waits(*first, 50, answers[0]));
  ASSERT_TRUE(Waits(*second, 50, answers[1]));
  GrantAnswer bob;
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
  GrantAnswer answer;
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
  GrantAnswer bob;
  auto waiting = Wait(kBob, 60, bob);
  holder->Lend();
  EXPECT_EQ(bob.count, 1);
  EXPECT_EQ(budget_.reserved(), 70u);
}

TEST_F(MemoryBudgetTurnsTest, WhoHasLentGrowsOnlyAsItNeedsAndWaitsForItsTurn) {
  auto holder = Make(kAlice);
  ASSERT_TRUE(*holder->GrowTo(90, 10, MustNotAnswer));
  GrantAnswer bob, alice;
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
  GrantAnswer bob;
  auto waiting = Wait(kBob, 60, bob);
  holder->Lend();
  EXPECT_EQ(bob.count, 0);
  EXPECT_EQ(budget_.reserved(), 90u);
}

}  // namespace
}  // namespace curvd
