#include "server/call/phase_clock.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using std::chrono::seconds;

PhaseClock::Clock::time_point At(int second) { return PhaseClock::Clock::time_point(seconds(second)); }

TEST(PhaseClockTest, WaitsForMemoryAreNoPartOfReceiving) {
  PhaseClock clock;
  clock.StartReceiving(At(10));
  clock.StartWaiting(At(11));
  clock.EndWaiting(At(13));
  clock.StartWaiting(At(14));
  clock.EndWaiting(At(18));
  clock.EndReceiving(At(20));
  EXPECT_EQ(clock.times().admit, 6.0);
  EXPECT_EQ(clock.times().receive, 4.0);
}

TEST(PhaseClockTest, ACallThatNeverWaitedWasAdmittedInNoTime) {
  PhaseClock clock;
  clock.StartReceiving(At(10));
  clock.StartWaiting(At(11));
  clock.EndWaiting(At(11));
  clock.EndReceiving(At(12));
  EXPECT_EQ(clock.times().admit, 0.0);
  EXPECT_EQ(clock.times().receive, 2.0);
}

TEST(PhaseClockTest, ACallThatWasRefusedAtOnceCountsInNoPhase) {
  PhaseClock clock;
  clock.StartReceiving(At(10));
  clock.StartWaiting(At(11));
  clock.ForgetWaiting();
  clock.End(At(12));
  EXPECT_FALSE(clock.times().admit.has_value());
  EXPECT_FALSE(clock.times().receive.has_value());
  EXPECT_FALSE(clock.times().send.has_value());
}

TEST(PhaseClockTest, TheEndEndsTheWaitThatGoesOn) {
  PhaseClock clock;
  clock.StartReceiving(At(10));
  clock.StartWaiting(At(11));
  clock.End(At(16));
  EXPECT_EQ(clock.times().admit, 5.0);
  EXPECT_EQ(clock.times().receive, 1.0);
}

TEST(PhaseClockTest, TheEndEndsTheSendingThatGoesOn) {
  PhaseClock clock;
  clock.StartReceiving(At(10));
  clock.StartWaiting(At(10));
  clock.EndWaiting(At(10));
  clock.EndReceiving(At(12));
  clock.SetJobSeconds({.queue = 1.0, .index = 2.0, .normals = 4.0, .orientation = {}, .estimate = {}});
  clock.StartSending(At(20));
  clock.End(At(23));
  EXPECT_EQ(clock.times().receive, 2.0);
  EXPECT_EQ(clock.times().queue, 1.0);
  EXPECT_EQ(clock.times().index, 2.0);
  EXPECT_EQ(clock.times().normals, 4.0);
  EXPECT_FALSE(clock.times().orientation.has_value());
  EXPECT_FALSE(clock.times().estimate.has_value());
  EXPECT_EQ(clock.times().send, 3.0);
}

TEST(PhaseClockTest, APhaseThatHasEndedStaysAsItIs) {
  PhaseClock clock;
  clock.StartSending(At(20));
  clock.EndSending(At(21));
  clock.End(At(30));
  EXPECT_EQ(clock.times().send, 1.0);
  EXPECT_FALSE(clock.times().receive.has_value());
}

}  // namespace
}  // namespace curvd
