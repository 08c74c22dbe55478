#include "server/rpc/peer_pace.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using Verdict = PeerPace::Verdict;
constexpr PeerPace::Clock::duration kPaceLimit = minutes(5);

// A peer, and a clock that moves when it is waited for.
struct Peer {
  PeerPace pace;
  PeerPace::Clock::time_point now;

  void Move(PeerPace::Clock::duration wait, uint64_t bytes) {
    pace.StartWait(now);
    now += wait;
    pace.EndWait(now);
    pace.CountProgress(bytes);
  }
  Verdict Judge() const { return pace.Judge(now, kPaceLimit); }
};

TEST(PeerPaceTest, AWaitWithoutProgressMayBeAsLongAsTheLimit) {
  Peer peer;
  peer.pace.StartWait(peer.now);
  EXPECT_EQ(peer.pace.Judge(peer.now + kPaceLimit, kPaceLimit), Verdict::kFine);
  EXPECT_EQ(peer.pace.Judge(peer.now + kPaceLimit + milliseconds(1), kPaceLimit), Verdict::kStalled);
}

TEST(PeerPaceTest, MessagesWithoutProgressDoNotStopTheClock) {
  Peer peer;
  for (int i = 0; i < 149; ++i) peer.Move(seconds(2), 0);
  EXPECT_EQ(peer.Judge(), Verdict::kFine);
  peer.Move(seconds(2), 0);
  EXPECT_EQ(peer.Judge(), Verdict::kStalled);
}

TEST(PeerPaceTest, MessagesWithoutProgressThatComeAtOnceEndToo) {
  Peer peer;
  for (int i = 0; i <= kPaceLimit / PeerPace::kEmptyMessage; ++i) peer.Move(seconds(0), 0);
  EXPECT_EQ(peer.Judge(), Verdict::kStalled);
}

TEST(PeerPaceTest, AByteNowAndThenIsSlowButNotStalled) {
  Peer peer;
  for (int i = 0; i < 151; ++i) peer.Move(seconds(2), 24);
  EXPECT_EQ(peer.Judge(), Verdict::kSlow);
}

TEST(PeerPaceTest, ALineOf56KilobytesASecondIsFineWithChunksOfAnySize) {
  for (const uint64_t chunk : {24, 1'000, 1 << 20, 4 << 20}) {
    Peer peer;
    const auto time = std::chrono::nanoseconds(static_cast<int64_t>(1e9 * static_cast<double>(chunk) / 56'000));
    while (peer.now < PeerPace::Clock::time_point(std::chrono::hours(1))) {
      peer.Move(time, chunk);
      ASSERT_EQ(peer.Judge(), Verdict::kFine) << chunk << " bytes";
      if (chunk < 1'000 && peer.now > PeerPace::Clock::time_point(kPaceLimit * 2)) break;
    }
  }
}

TEST(PeerPaceTest, WhoWasSlowWhileNobodyWaitedGetsTimeToHurry) {
  Peer peer;
  for (int i = 0; i < 3'600; ++i) peer.Move(seconds(2), 24);
  peer.pace.CapLag(peer.now, kPaceLimit / 2);
  for (int i = 0; i < 74; ++i) peer.Move(seconds(2), 24);
  EXPECT_EQ(peer.Judge(), Verdict::kFine);
  for (int i = 0; i < 2; ++i) peer.Move(seconds(2), 24);
  EXPECT_EQ(peer.Judge(), Verdict::kSlow);
}

TEST(PeerPaceTest, TheWaitThatGoesOnCountsAsLagThatIsCapped) {
  Peer peer;
  peer.Move(minutes(4), 24);
  peer.pace.StartWait(peer.now);
  peer.now += minutes(4);
  peer.pace.CapLag(peer.now, kPaceLimit / 2);
  EXPECT_EQ(peer.pace.Judge(peer.now + seconds(59), kPaceLimit), Verdict::kFine);
  EXPECT_EQ(peer.pace.Judge(peer.now + minutes(1) + seconds(1), kPaceLimit), Verdict::kStalled);
}

TEST(PeerPaceTest, NobodyIsPaidInAdvance) {
  Peer peer;
  peer.Move(seconds(1), uint64_t{1} << 40);
  for (int i = 0; i < 151; ++i) peer.Move(seconds(2), 24);
  EXPECT_EQ(peer.Judge(), Verdict::kSlow);
}

TEST(PeerPaceTest, TimeInWhichNobodyWaitsForThePeerDoesNotCount) {
  Peer peer;
  peer.Move(seconds(1), 0);
  EXPECT_EQ(peer.pace.Judge(peer.now + std::chrono::hours(1), kPaceLimit), Verdict::kFine);
}

}  // namespace
}  // namespace curvd
