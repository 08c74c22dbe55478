#include "server/rpc/stream_state.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using Step = StreamState::Step;
using Stall = StreamState::Stall;
using std::chrono::seconds;

const StreamState::Clock::time_point kStart{};

TEST(StreamStateTest, MakesNoMessageWhileOneIsOnItsWay) {
  StreamState state;
  ASSERT_EQ(state.Next(), Step::kMakeMessage);
  EXPECT_EQ(state.Next(), Step::kNothing);
  state.StartWrite(kStart);
  EXPECT_EQ(state.Next(), Step::kNothing);
  state.EndWrite(kStart, 1);
  EXPECT_EQ(state.Next(), Step::kMakeMessage);
}

TEST(StreamStateTest, AsksAgainIfSomethingMayHaveBecomeDueMeanwhile) {
  StreamState state;
  state.Next();
  EXPECT_FALSE(state.SkipWrite());
  state.Next();
  state.Next();
  EXPECT_TRUE(state.SkipWrite());
  state.Next();
  EXPECT_FALSE(state.SkipWrite());
}

TEST(StreamStateTest, FinishesOnceAndOnlyAfterTheWriteInFlight) {
  StreamState state;
  state.Next();
  state.StartWrite(kStart);
  EXPECT_TRUE(state.End(absl::OkStatus()));
  EXPECT_EQ(state.Next(), Step::kNothing);
  state.EndWrite(kStart, 1);
  EXPECT_EQ(state.Next(), Step::kFinish);
  EXPECT_EQ(state.Next(), Step::kNothing);
}

TEST(StreamStateTest, DoesNotFinishWhileAMessageIsBeingMade) {
  StreamState state;
  state.Next();
  state.End(absl::OkStatus());
  EXPECT_EQ(state.Next(), Step::kNothing);
  EXPECT_TRUE(state.SkipWrite());
  EXPECT_EQ(state.Next(), Step::kFinish);
}

TEST(StreamStateTest, DoesNotFinishWhileItIsHeld) {
  StreamState state;
  state.Hold();
  state.Hold();
  EXPECT_FALSE(state.Release());
  state.End(absl::OkStatus());
  EXPECT_EQ(state.Next(), Step::kNothing);
  EXPECT_TRUE(state.Release());
  EXPECT_EQ(state.Next(), Step::kFinish);
}

// A read may be in flight for as long as the peer likes, and must not delay the status.
TEST(StreamStateTest, FinishesWhileAReadIsInFlight) {
  StreamState state;
  ASSERT_TRUE(state.StartRead(kStart));
  state.End(absl::OkStatus());
  EXPECT_EQ(state.Next(), Step::kFinish);
}

TEST(StreamStateTest, KeepsTheFirstOutcome) {
  StreamState state;
  EXPECT_FALSE(state.outcome().has_value());
  EXPECT_TRUE(state.End(absl::InternalError("first")));
  EXPECT_FALSE(state.End(absl::OkStatus()));
  EXPECT_EQ(state.outcome()->message(), "first");
}

TEST(StreamStateTest, ReadsNoMoreOnceThereIsAnOutcome) {
  StreamState state;
  ASSERT_TRUE(state.StartRead(kStart));
  EXPECT_TRUE(state.EndRead(kStart));
  ASSERT_TRUE(state.StartRead(kStart));
  state.End(absl::OkStatus());
  EXPECT_FALSE(state.EndRead(kStart));
  EXPECT_FALSE(state.StartRead(kStart));
}

TEST(StreamStateTest, TellsWhichSideStalls) {
  StreamState state;
  EXPECT_EQ(state.FindStall(kStart + seconds(100), seconds(10)), Stall::kNone);
  state.StartRead(kStart);
  EXPECT_EQ(state.FindStall(kStart + seconds(10), seconds(10)), Stall::kNone);
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kWithoutMessage);
  state.EndRead(kStart + seconds(11));
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
  state.JudgeWrites(kStart);
  state.Next();
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
  state.StartWrite(kStart + seconds(5));
  EXPECT_EQ(state.FindStall(kStart + seconds(15), seconds(10)), Stall::kNone);
  EXPECT_EQ(state.FindStall(kStart + seconds(16), seconds(10)), Stall::kWithoutRoomToSend);
  state.EndWrite(kStart, 1);
  EXPECT_EQ(state.FindStall(kStart + seconds(16), seconds(10)), Stall::kNone);
}

TEST(StreamStateTest, MessagesThatBringNothingDoNotKeepAStreamAlive) {
  StreamState state;
  for (int i = 0; i < 11; ++i) {
    state.StartRead(kStart + seconds(i));
    state.EndRead(kStart + seconds(i + 1));
    state.CountReceived(0);
  }
  state.StartRead(kStart + seconds(11));
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kWithoutMessage);
  state.EndRead(kStart + seconds(11));
  state.CountReceived(1);
  state.StartRead(kStart + seconds(11));
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
}

TEST(StreamStateTest, SlowPeersAreFoundOnlyIfOthersMissWhatTheCallHolds) {
  StreamState state;
  for (int i = 0; i < 11; ++i) {
    state.StartRead(kStart + seconds(i));
    state.EndRead(kStart + seconds(i + 1));
    state.CountReceived(24);
  }
  state.StartRead(kStart + seconds(11));
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10), true), Stall::kSendsSlowly);
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
  state.EndRead(kStart + seconds(11));
  state.JudgeWrites(kStart);
  for (int i = 0; i < 11; ++i) {
    state.Next();
    state.StartWrite(kStart + seconds(i));
    state.EndWrite(kStart + seconds(i + 1), 24);
  }
  state.Next();
  state.StartWrite(kStart + seconds(11));
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10), true), Stall::kTakesSlowly);
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
}

TEST(StreamStateTest, ASlowPeerIsNotCutOffAtOnceWhenOthersComeToMissWhatTheCallHolds) {
  StreamState state;
  for (int i = 0; i < 100; ++i) {
    state.StartRead(kStart + seconds(i));
    state.EndRead(kStart + seconds(i + 1));
    state.CountReceived(24);
    ASSERT_EQ(state.FindStall(kStart + seconds(i + 1), seconds(10)), Stall::kNone);
  }
  state.StartRead(kStart + seconds(100));
  EXPECT_EQ(state.FindStall(kStart + seconds(104), seconds(10), true), Stall::kNone);
  EXPECT_EQ(state.FindStall(kStart + seconds(106), seconds(10), true), Stall::kSendsSlowly);
}

// As a client does that sends its whole cloud before it reads: what tells of progress fills its window.
TEST(StreamStateTest, APeerNeedNotTakeAnythingUntilWritesAreJudged) {
  StreamState state;
  state.Next();
  state.StartWrite(kStart);
  EXPECT_EQ(state.FindStall(kStart + seconds(100), seconds(10), true), Stall::kNone);
  state.JudgeWrites(kStart + seconds(100));
  EXPECT_EQ(state.FindStall(kStart + seconds(110), seconds(10), true), Stall::kNone);
  EXPECT_EQ(state.FindStall(kStart + seconds(111), seconds(10)), Stall::kWithoutRoomToSend);
}

// The ticker may have looked at its clock before the read started.
TEST(StreamStateTest, ATickFromBeforeTheReadIsNoStall) {
  StreamState state;
  state.StartRead(kStart + seconds(100));
  EXPECT_EQ(state.FindStall(kStart, seconds(10)), Stall::kNone);
}

// The status waits behind the write: a peer that takes nothing would keep the call, and its memory, for ever.
TEST(StreamStateTest, AWriteStallsAlsoWhenThereIsAnOutcome) {
  StreamState state;
  state.StartRead(kStart);
  state.Next();
  state.StartWrite(kStart);
  state.End(absl::InvalidArgumentError("bad"));
  state.JudgeWrites(kStart);
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kWithoutRoomToSend);
  state.EndWrite(kStart, 1);
  EXPECT_EQ(state.FindStall(kStart + seconds(11), seconds(10)), Stall::kNone);
}

}  // namespace
}  // namespace curvd
