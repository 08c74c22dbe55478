#include "server/net/stranger_rations.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <deque>
#include <string>
#include <vector>

#include "server/net/tcp_counts.h"
#include "tests/server/net/socket_pair.h"

namespace curvd {
namespace {

using Use = StrangerRations::Use;

constexpr uint64_t kMost = 48 << 10;  // less than the system receives before a connection is accepted
constexpr uint64_t kTotal = 20 << 10;
constexpr uint64_t kCall = 4 << 10;
constexpr uint64_t kCommon = kTotal - kTotal / StrangerRations::kNewcomersShare;

class StrangerRationsTest : public ::testing::Test {
 protected:
  StrangerRationsTest() { rations_.Share(kTotal); }

  // The server's socket of a connection whose client has sent `bytes` before it was accepted.
  int Connect(size_t bytes = 0) {
    pairs_.emplace_back();
    Send(pairs_.back().server(), bytes);
    return pairs_.back().server();
  }
  // The same, and it has come in, has got what there is for it, and has sent `bytes` after that.
  int Enter(size_t bytes) {
    const int fd = Connect();
    EXPECT_TRUE(rations_.Add(fd, now_));
    Send(fd, bytes);
    Note(fd);
    return fd;
  }
  void Send(int server, size_t bytes) {
    const auto pair =
        std::find_if(pairs_.begin(), pairs_.end(), [&](const TcpPair& p) { return p.server() == server; });
    const std::string sent(bytes, 'x');
    ASSERT_EQ(send(pair->client(), sent.data(), bytes, 0), static_cast<ssize_t>(bytes));
  }
  // The same where little is left to the silent, since there is little, and four wait at the door for all of it.
  int EnterACrowd(size_t bytes) {
    rations_.Share(kCall + StrangerRations::kNewcomerBytes);
    const int fd = Enter(bytes);
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(rations_.Add(Connect(kTotal), now_));  // more than there is
    DivideAfter(StrangerRations::kSilence);
    return fd;
  }
  // Or the system would soon receive no more.
  static void Read(int fd) {
    std::array<char, 10'000> read;
    recv(fd, read.data(), read.size(), MSG_DONTWAIT);
  }
  // gRPC has read all that was received.
  Use Note(int fd, uint64_t accounted = 0) {
    const uint64_t received = CountsOf(fd).received;
    return rations_.Note(fd, received, received, accounted, now_);
  }
  StrangerRations::Division DivideAfter(std::chrono::milliseconds time) {
    now_ += time;
    return rations_.Divide(now_);
  }

  std::deque<TcpPair> pairs_;
  StrangerRations rations_{kMost, kCall};
  StrangerRations::Clock::time_point now_ = StrangerRations::Clock::now();
};

TEST_F(StrangerRationsTest, EachGetsAllThatOneMayHaveWhileThereIsPlenty) {
  rations_.Share(UINT64_MAX);
  for (int i = 0; i < 3; ++i) {
    const int fd = Enter(kMost + 1'000);
    EXPECT_EQ(CountsOf(fd).received, kMost + StrangerRations::kGreetingBytes);
    EXPECT_EQ(Note(fd), Use::kAll);
  }
  EXPECT_EQ(rations_.held(), 3 * kMost);
  EXPECT_FALSE(DivideAfter(std::chrono::seconds(5)).end.has_value()) << "nobody can get more";
}

TEST_F(StrangerRationsTest, TheSystemHoldsAllWhoAreInsideTogetherToTheTotal) {
  uint64_t inside = 0;
  for (int i = 0; i < 50; ++i) {
    const int fd = Connect();
    const bool is_inside = rations_.Add(fd, now_);
    Send(fd, kTotal);
    Note(fd);
    if (is_inside) inside += CountsOf(fd).received;
    EXPECT_LE(CountsOf(fd).received, kTotal);
  }
  EXPECT_LE(rations_.held(), kTotal);
  EXPECT_LE(inside, kTotal + 50 * StrangerRations::kGreetingBytes);
  EXPECT_GT(inside, kTotal - kTotal / 4) << "it is there to be used";
}

TEST_F(StrangerRationsTest, TheSystemHoldsWhoWaitsAtTheDoorToWhatANewcomerNeeds) {
  rations_.Share(0);
  const int fd = Connect();
  EXPECT_FALSE(rations_.Add(fd, now_));
  Send(fd, kTotal);
  EXPECT_EQ(CountsOf(fd).received, StrangerRations::kGreetingBytes + StrangerRations::kNewcomerBytes);
  EXPECT_EQ(rations_.held(), 0u);
}

TEST_F(StrangerRationsTest, WhoSentTooMuchBeforeHeCameInWaitsAtTheDoor) {
  const int first = Enter(1'000);
  const int patient = Connect(kCommon - 1'000);
  EXPECT_FALSE(rations_.Add(patient, now_));
  EXPECT_TRUE(DivideAfter(std::chrono::milliseconds(1)).enter.empty());
  rations_.Lift(first);
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(1)).enter, std::vector<int>{patient});
  EXPECT_TRUE(DivideAfter(std::chrono::milliseconds(1)).enter.empty()) << "once";
}

TEST_F(StrangerRationsTest, WhoWaitsAtTheDoorForLongHasToGo) {
  const int patient = Connect(kTotal + 1'000);
  EXPECT_FALSE(rations_.Add(patient, now_));
  EXPECT_FALSE(DivideAfter(StrangerRations::kDoorPatience - std::chrono::milliseconds(1)).end.has_value());
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(1)).end, patient);
}

TEST_F(StrangerRationsTest, WhoSentMoreThanOneMayBeforeHeCameInSentTooMuch) {
  const int greedy = Connect(StrangerRations::kGreetingBytes + kMost - 1), greedier = Connect(kMost + 1'000);
  EXPECT_FALSE(rations_.Add(greedy, now_));
  EXPECT_EQ(Note(greedy), Use::kAll);
  EXPECT_FALSE(rations_.Add(greedier, now_));
  EXPECT_EQ(Note(greedier), Use::kTooMuch);
}

TEST_F(StrangerRationsTest, WhoSendsMuchLeavesAPartToNewcomers) {
  EXPECT_TRUE(rations_.Add(Connect(kCommon), now_));
  const int another = Connect(kCommon);
  EXPECT_FALSE(rations_.Add(another, now_));
  EXPECT_TRUE(DivideAfter(std::chrono::milliseconds(1)).enter.empty());
  EXPECT_EQ(CountsOf(Enter(StrangerRations::kNewcomerBytes)).received, StrangerRations::kNewcomerBytes);
}

TEST_F(StrangerRationsTest, AnswersGiveABoundBackToWhoGotThem) {
  const int fd = Enter(kTotal);
  const uint64_t before = CountsOf(fd).received;
  EXPECT_EQ(Note(fd), Use::kAll);
  EXPECT_EQ(Note(fd, before), Use::kPart);
  EXPECT_EQ(rations_.held(), before - StrangerRations::kGreetingBytes) << "what it may have unaccounted for";
}

TEST_F(StrangerRationsTest, WhoSendsAnsweredCallsAsFastAsHeCanSendsTooMuch) {
  rations_.Share(UINT64_MAX);
  const int fd = Enter(kMost + 1'000);
  EXPECT_EQ(Note(fd, StrangerRations::kStepBytes / 2), Use::kAll);
  EXPECT_EQ(Note(fd, 2 * StrangerRations::kStepBytes), Use::kTooMuch);
}

TEST_F(StrangerRationsTest, WhatTheSilentDoNotUseGoesToWhoWaits) {
  const int silent = Enter(100);
  const int patient = Connect(kCommon - 2'000);
  EXPECT_FALSE(rations_.Add(patient, now_));
  EXPECT_TRUE(DivideAfter(StrangerRations::kSilence - std::chrono::milliseconds(1)).enter.empty());
  DivideAfter(std::chrono::milliseconds(StrangerRations::kTakeBackInterval));
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(1)).enter, std::vector<int>{patient});
  Send(silent, 2'000);
  EXPECT_EQ(CountsOf(silent).received, 100 + rations_.KnockBytes());
  EXPECT_EQ(Note(silent), Use::kAll) << "it wants more";
}

TEST_F(StrangerRationsTest, WhoTricklesKeepsWhatHeDoesNotUseNoLongerThanTheSilent) {
  const int trickling = Enter(100);
  const int patient = Connect(kCommon - 2'000);
  EXPECT_FALSE(rations_.Add(patient, now_));
  const auto trickle_for = [&](std::chrono::milliseconds time) {
    for (const auto end = now_ + time; now_ < end;) {
      Send(trickling, 1);
      Note(trickling);
      Read(trickling);
      if (!DivideAfter(std::chrono::milliseconds(20)).enter.empty()) return true;
    }
    return false;
  };
  EXPECT_FALSE(trickle_for(StrangerRations::kStay - std::chrono::milliseconds(20)));
  EXPECT_TRUE(trickle_for(std::chrono::milliseconds(60)));
}

TEST_F(StrangerRationsTest, ThoseWhoWaitedGetACallEach) {
  rations_.Share(0);
  std::vector<int> waiting;
  for (int i = 0; i < 3; ++i) {
    waiting.push_back(Connect(3'000));
    EXPECT_FALSE(rations_.Add(waiting.back(), now_));
  }
  rations_.Share(kTotal);
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(1)).enter, waiting);
  for (const int fd : waiting) {
    Send(fd, kTotal);
    EXPECT_EQ(CountsOf(fd).received, StrangerRations::kGreetingBytes + kCall);
  }
}

// TCP sends again what was cut off after a pause that doubles each time: what is given meanwhile has to be there then.
TEST_F(StrangerRationsTest, WhoWaitedKeepsWhatHeGetsUntilBytesComeOrMustHaveCome) {
  const int silent = EnterACrowd(100);
  Send(silent, rations_.KnockBytes());  // no more, or TCP would send it again
  EXPECT_EQ(Note(silent), Use::kAll);
  const auto waited = std::chrono::milliseconds(5);
  DivideAfter(waited);
  DivideAfter(StrangerRations::kShortestPause + waited - std::chrono::milliseconds(1));
  EXPECT_EQ(rations_.held(), StrangerRations::kNewcomerBytes) << "and no more than that";
  DivideAfter(StrangerRations::kTakeBackInterval);
  EXPECT_EQ(rations_.held(), 100 - StrangerRations::kGreetingBytes + 2 * rations_.KnockBytes());
}

// Its peer's system sends again what is left, after twice the pause, though some of it came.
TEST_F(StrangerRationsTest, WhoIsCutOffAgainKeepsWhatHeGetsForLonger) {
  const int fd = EnterACrowd(100);
  Send(fd, rations_.KnockBytes());
  Note(fd);
  const auto waited = std::chrono::milliseconds(400);
  DivideAfter(waited);
  Send(fd, StrangerRations::kNewcomerBytes - CountsOf(fd).received + StrangerRations::kGreetingBytes);
  EXPECT_EQ(Note(fd), Use::kAll);
  DivideAfter(std::chrono::milliseconds(0));
  EXPECT_EQ(rations_.held(), kCall);
  DivideAfter(StrangerRations::kShortestPause + waited - std::chrono::milliseconds(1));
  EXPECT_EQ(rations_.held(), kCall);
  DivideAfter(StrangerRations::kTakeBackInterval);
  EXPECT_EQ(rations_.held(), StrangerRations::kNewcomerBytes + rations_.KnockBytes());
}

TEST_F(StrangerRationsTest, WhoHasHeldMostForLongestHasToGoForThoseWhoWait) {
  const int small = Enter(500), large = Enter(5'000);
  now_ += StrangerRations::kStay;
  const int waiting = Connect(kCommon - 2'000);
  EXPECT_FALSE(rations_.Add(waiting, now_));
  EXPECT_FALSE(DivideAfter(std::chrono::milliseconds(0)).end.has_value()) << "not at once";
  EXPECT_EQ(DivideAfter(StrangerRations::kScarcity).end, large);
  EXPECT_EQ(Note(small), Use::kPart);
}

// A busy server may not have come to it.
TEST_F(StrangerRationsTest, NobodyHasToGoForBytesThatGrpcHasNotReadForLong) {
  const int late = Connect();
  EXPECT_TRUE(rations_.Add(late, now_));
  Send(late, 5'000);
  EXPECT_EQ(rations_.Note(late, 5'000, 0, 0, now_), Use::kPart);
  EXPECT_FALSE(rations_.Add(Connect(kCommon - 2'000), now_));
  EXPECT_FALSE(DivideAfter(std::chrono::seconds(5)).end.has_value());
  rations_.Note(late, 5'000, 5'000, 0, now_);
  EXPECT_FALSE(DivideAfter(StrangerRations::kStay - std::chrono::milliseconds(1)).end.has_value());
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(1)).end, late);
}

TEST_F(StrangerRationsTest, WhoIsAnsweredWhileHeWaitsKeepsNothing) {
  const int fd = Enter(kTotal);
  EXPECT_EQ(Note(fd), Use::kAll);
  EXPECT_FALSE(rations_.Add(Connect(kTotal), now_)) << "so that somebody waits";
  Note(fd, CountsOf(fd).received);
  DivideAfter(StrangerRations::kSilence);
  EXPECT_EQ(rations_.held(), rations_.KnockBytes());
}

TEST_F(StrangerRationsTest, NobodyIsPromisedMoreAgainAndAgain) {
  const int knocking = EnterACrowd(100);
  const auto held_after_a_knock = [&] {
    Send(knocking, rations_.KnockBytes());
    Note(knocking);
    DivideAfter(std::chrono::milliseconds(0));
    DivideAfter(StrangerRations::kSilence);
    return rations_.held();
  };
  for (int i = 0; i < StrangerRations::kPromises; ++i) {
    EXPECT_EQ(held_after_a_knock(), StrangerRations::kNewcomerBytes);
    DivideAfter(StrangerRations::kLongestPause + StrangerRations::kShortestPause);
  }
  EXPECT_LT(held_after_a_knock(), StrangerRations::kNewcomerBytes);
}

TEST_F(StrangerRationsTest, WhoGetsWhatHeWaitedForKeepsTheRestNotForLong) {
  const int fd = EnterACrowd(100);
  Send(fd, rations_.KnockBytes());
  Note(fd);
  DivideAfter(std::chrono::seconds(5));
  Send(fd, 10);
  Note(fd);
  DivideAfter(StrangerRations::kShortestPause - std::chrono::milliseconds(1));
  EXPECT_EQ(rations_.held(), StrangerRations::kNewcomerBytes);
  DivideAfter(StrangerRations::kTakeBackInterval);
  EXPECT_EQ(rations_.held(), 110 - StrangerRations::kGreetingBytes + 2 * rations_.KnockBytes());
}

// At the door anybody may have sent much, and holds nothing that he could be ended for.
TEST_F(StrangerRationsTest, WhoIsInsideGoesOnBeforeThoseAtTheDoor) {
  rations_.Share(0);
  const int at_door = Connect(StrangerRations::kNewcomerBytes + 500);
  EXPECT_FALSE(rations_.Add(at_door, now_));
  rations_.Share(2 * kCall + 200);  // enough for either of them
  const int inside = Enter(StrangerRations::kGreetingBytes + StrangerRations::kNewcomerBytes);
  EXPECT_EQ(Note(inside), Use::kAll);
  EXPECT_TRUE(DivideAfter(std::chrono::milliseconds(0)).enter.empty());
  EXPECT_EQ(rations_.held(), kCall);
  rations_.Lift(inside);
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(0)).enter, std::vector<int>{at_door});
}

// All metadata that a call may have can be more than there ever is beside newcomers.
TEST_F(StrangerRationsTest, WhoMayNeedMoreThanThereIsGetsWhatThereIs) {
  StrangerRations rations(kMost, kTotal);
  rations.Share(kTotal);
  const int fd = Connect();
  EXPECT_TRUE(rations.Add(fd, now_));
  EXPECT_FALSE(rations.Add(Connect(kMost), now_)) << "so that somebody waits";
  Send(fd, kTotal);
  const uint64_t received = CountsOf(fd).received;
  rations.Note(fd, received, received, 0, now_);
  rations.Divide(now_);
  EXPECT_GE(rations.held(), kTotal / 2);
}

// Bytes that are answered at once take the place of others that were.
TEST_F(StrangerRationsTest, WhoSendsMuchThatIsAnsweredHoldsTheRestNoShorter) {
  constexpr uint64_t kHeld = 3'000, kStep = 2'000;  // more than a quarter of the ration
  const int fd = Enter(StrangerRations::kGreetingBytes + kHeld);
  EXPECT_FALSE(rations_.Add(Connect(kCommon - 500), now_));
  const auto step = std::chrono::milliseconds(40);
  uint64_t answered = StrangerRations::kGreetingBytes;
  for (auto age = step; age < StrangerRations::kStay; age += step) {
    EXPECT_FALSE(DivideAfter(step).end.has_value());
    Send(fd, kStep);
    Read(fd);
    Note(fd, answered += kStep);
  }
  EXPECT_EQ(DivideAfter(2 * step).end, fd);
}

// A busy server reads what was sent and lets in who sent it: that nothing is left meanwhile is not for those who are
// in.
TEST_F(StrangerRationsTest, NobodyHasToGoWhoHoldsTooLittleToHelp) {
  constexpr uint64_t kLittle = kTotal / StrangerRations::kHoldersShare - 1;
  const int little = Enter(StrangerRations::kGreetingBytes + kLittle);
  const int unread = Connect();
  EXPECT_TRUE(rations_.Add(unread, now_));
  Send(unread, kTotal);
  rations_.Note(unread, CountsOf(unread).received, 0, 0, now_);
  EXPECT_FALSE(rations_.Add(Connect(kCommon), now_));
  EXPECT_FALSE(DivideAfter(std::chrono::seconds(5)).end.has_value());
  Send(little, 1);
  Note(little);
  EXPECT_EQ(DivideAfter(StrangerRations::kStay).end, little);
}

TEST_F(StrangerRationsTest, WhoHasBeenInForLongMaySendMuchAndStayAWhile) {
  const int fd = Enter(StrangerRations::kGreetingBytes + 1'000);
  EXPECT_FALSE(rations_.Add(Connect(kCommon - 2'000), now_));
  now_ += std::chrono::seconds(2);
  Send(fd, 4'000);
  Note(fd);  // 1,000 bytes since 2 s and 4,000 since now: 0.4 s on average
  EXPECT_FALSE(DivideAfter(StrangerRations::kTakeBackInterval).end.has_value());
  EXPECT_FALSE(DivideAfter(std::chrono::milliseconds(575)).end.has_value());
  EXPECT_EQ(DivideAfter(std::chrono::milliseconds(10)).end, fd);
}

TEST_F(StrangerRationsTest, NobodyHasToGoWhileNobodyWaits) {
  Enter(5'000);
  EXPECT_FALSE(DivideAfter(std::chrono::hours(1)).end.has_value());
}

TEST_F(StrangerRationsTest, WhatOneHasUsedWhoEndedCountsForAWhile) {
  const int fd = Enter(5'000);
  rations_.End(fd, now_);
  EXPECT_EQ(rations_.held(), 5'000 - StrangerRations::kGreetingBytes);
  DivideAfter(StrangerRations::kAftermath - std::chrono::milliseconds(1));
  EXPECT_EQ(rations_.held(), 5'000 - StrangerRations::kGreetingBytes);
  DivideAfter(std::chrono::milliseconds(1));
  EXPECT_EQ(rations_.held(), 0u);
}

TEST_F(StrangerRationsTest, WhoIsLetInGetsWhatHeSentAndLeavesHisRation) {
  const int fd = Enter(kTotal);
  EXPECT_LT(CountsOf(fd).received, kTotal);
  rations_.Lift(fd);
  EXPECT_EQ(rations_.held(), 0u);
  std::string all(kTotal, ' ');
  EXPECT_EQ(recv(fd, all.data(), all.size(), MSG_WAITALL), static_cast<ssize_t>(kTotal));
  EXPECT_EQ(Note(fd), Use::kPart);
}

}  // namespace
}  // namespace curvd
