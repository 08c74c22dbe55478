#include "server/net/connection_guard.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/server/net/socket_pair.h"

namespace curvd {
namespace {

constexpr uint64_t kLimit = 256 << 20;
constexpr uint64_t kMuch = kLimit + MemoryPressure::kCriticalBytes + 1;

// A guard of connections that are numbered from 0 on, each given `bytes` bytes.
class ConnectionGuardTest : public ::testing::Test {
 protected:
  void Send(const TcpPair& pair, size_t bytes) {
    const std::string sent(bytes, 'x');
    ASSERT_EQ(send(pair.client(), sent.data(), sent.size(), 0), static_cast<ssize_t>(bytes));
  }
  int Add(const TcpPair& pair) {
    const int watch = connections_.Add(pair.server(), absl::StrCat("ipv4:10.0.0.7:", ++ports_))->watch;
    guard_.Wake(watch);
    return watch;
  }
  // The same, and gRPC reads them.
  void SendAndRead(const TcpPair& pair, size_t bytes) {
    Send(pair, bytes);
    std::string read(bytes, ' ');
    ASSERT_EQ(recv(pair.server(), read.data(), bytes, MSG_WAITALL), static_cast<ssize_t>(bytes));
  }
  // Adds them all, and has each send `bytes`, which gRPC does not read.
  std::vector<int> AddSending(std::span<const TcpPair> pairs, size_t bytes) {
    std::vector<int> watches;
    for (const TcpPair& pair : pairs) {
      watches.push_back(Add(pair));
      Send(pair, bytes);
    }
    return watches;
  }
  std::string LastPeer() const { return absl::StrCat("ipv4:10.0.0.7:", ports_); }
  // Takes a turn after the last one.
  std::vector<int> Turn(uint64_t resident_bytes) {
    now_ += ConnectionGuard::kInterval;
    return guard_.Turn(now_, resident_bytes).quiet;
  }
  static bool HasEnded(int watch) {
    pollfd ended = {watch, 0, 0};
    return poll(&ended, 1, 0) == 1 && (ended.revents & POLLHUP) != 0;
  }

  static ptrdiff_t CountEnded(const std::vector<int>& watches) {
    return std::count_if(watches.begin(), watches.end(), HasEnded);
  }

  ConnectionRegistry connections_;
  MemoryPressure memory_{kLimit};
  ConnectionGuard guard_{connections_, memory_};
  ConnectionGuard::Clock::time_point now_ = ConnectionGuard::Clock::now();
  int ports_ = 0;
};

TEST_F(ConnectionGuardTest, SleepsWhileAllIsQuiet) {
  EXPECT_EQ(guard_.WaitMs(now_), -1);
  const TcpPair pair;
  const int watch = Add(pair);
  EXPECT_EQ(guard_.WaitMs(now_), 0);
  std::vector<int> quiet;
  int turns = 0;
  for (; quiet.empty() && turns < 1'000; ++turns) quiet = Turn(0);
  EXPECT_EQ(quiet, std::vector<int>{watch});
  EXPECT_EQ(turns, ConnectionGuard::kQuietLooks);
  EXPECT_EQ(guard_.WaitMs(now_), -1);
}

TEST_F(ConnectionGuardTest, WaitsForTheNextTurnWhileBytesCome) {
  const TcpPair pair;
  Add(pair);
  Turn(0);
  EXPECT_EQ(guard_.WaitMs(now_), ConnectionGuard::kInterval.count());
  EXPECT_EQ(guard_.WaitMs(now_ + std::chrono::milliseconds(3)), 2);
  EXPECT_EQ(guard_.WaitMs(now_ + std::chrono::hours(1)), 0);
}

TEST_F(ConnectionGuardTest, LooksLessOftenWhereNobodyIsAStranger) {
  const TcpPair pair, stranger;
  Add(pair);
  connections_.NoteCall(LastPeer(), ConnectionRegistry::Call::kLetIn, 100);
  Turn(0);
  EXPECT_EQ(guard_.WaitMs(now_), ConnectionGuard::kLongInterval.count());
  Add(stranger);
  EXPECT_EQ(guard_.WaitMs(now_), ConnectionGuard::kInterval.count());
}

// Half a header, and nothing more.
TEST_F(ConnectionGuardTest, EndsAStrangerWhoStopsInTheMiddleOfACall) {
  const TcpPair pair;
  const int watch = Add(pair);
  SendAndRead(pair, 20'000);
  std::vector<int> quiet;
  for (int turns = 0; quiet.empty() && turns < 1'000; ++turns) quiet = Turn(0);
  EXPECT_EQ(quiet, std::vector<int>{watch});
  int seconds = 0;
  for (; !HasEnded(watch) && seconds < 100; ++seconds) {
    EXPECT_GT(guard_.WaitMs(now_), 0);
    EXPECT_LE(guard_.WaitMs(now_), ConnectionGuard::kSlowInterval.count());
    now_ += ConnectionGuard::kSlowInterval;
    guard_.Turn(now_, 0);
  }
  EXPECT_NEAR(seconds, ByteAllowances().patience().count(), 2);
  now_ += ConnectionGuard::kSlowInterval;
  guard_.Turn(now_, 0);
  EXPECT_EQ(guard_.WaitMs(now_), -1);
  EXPECT_EQ(connections_.Remove(watch).closed_for, StrangerReason::kUnaccountedBytes);
}

TEST_F(ConnectionGuardTest, ForgetsStrangersWhoOweNothingAnyMore) {
  const TcpPair answered, gone;
  const int answered_watch = Add(answered);
  const std::string peer = LastPeer();
  const int gone_watch = Add(gone);
  SendAndRead(answered, ConnectionRegistry::kSparedBytes + 100);
  SendAndRead(gone, ConnectionRegistry::kSparedBytes + 100);
  for (int turns = 0; turns < ConnectionGuard::kQuietLooks + 1; ++turns) Turn(0);
  guard_.Forget(gone_watch);
  connections_.Remove(gone_watch);
  connections_.NoteAnswered(peer, 100);
  for (int seconds = 0; seconds < 100; ++seconds) {
    now_ += ConnectionGuard::kSlowInterval;
    guard_.Turn(now_, 0);
  }
  EXPECT_FALSE(HasEnded(answered_watch));
  EXPECT_EQ(guard_.WaitMs(now_), -1);
}

TEST_F(ConnectionGuardTest, ForgetsConnectionsThatAreGone) {
  const TcpPair pair;
  const int watch = Add(pair);
  guard_.Forget(watch);
  connections_.Remove(watch);
  EXPECT_TRUE(Turn(0).empty());
  EXPECT_EQ(guard_.WaitMs(now_), -1);
}

TEST_F(ConnectionGuardTest, SparesWhoHasSentAHandshakeWhateverTheMemory) {
  const TcpPair pair;
  const int watch = Add(pair);
  Send(pair, ConnectionRegistry::kSparedBytes);
  for (int turn = 0; turn < 5; ++turn) Turn(kMuch);
  EXPECT_FALSE(HasEnded(watch));
}

// As probes of Kubernetes do that keep their connection.
TEST_F(ConnectionGuardTest, SparesWhoseCallsAreAnsweredWhateverTheMemory) {
  const TcpPair pair;
  const int watch = Add(pair);
  for (int probe = 0; probe < 5'000; ++probe) {
    SendAndRead(pair, 300);
    Turn(kLimit);
    connections_.NoteAnswered(LastPeer(), 100);
    Turn(kLimit);
  }
  for (int turn = 0; turn < 5; ++turn) Turn(kMuch);
  EXPECT_FALSE(HasEnded(watch));
}

TEST_F(ConnectionGuardTest, EndsTheLargestStrangerFirst) {
  const TcpPair small, large;
  const int small_watch = Add(small), large_watch = Add(large);
  Send(small, 20'000);
  Send(large, 30'000);
  const uint64_t high = kLimit + MemoryPressure::kHighBytes + 1;
  Turn(high);
  EXPECT_FALSE(HasEnded(large_watch)) << "what was freed goes first";
  Turn(high);
  EXPECT_TRUE(HasEnded(large_watch));
  EXPECT_FALSE(HasEnded(small_watch));
  EXPECT_EQ(connections_.Remove(large_watch).closed_for, StrangerReason::kMemoryShort);
}

TEST_F(ConnectionGuardTest, EndsAllStrangersAndTakesNobodyWhileMemoryIsCritical) {
  const TcpPair first, second;
  const int first_watch = Add(first), second_watch = Add(second);
  Send(first, 20'000);
  Send(second, 20'000);
  EXPECT_TRUE(guard_.MayTake());
  Turn(kMuch);
  EXPECT_TRUE(HasEnded(first_watch));
  EXPECT_TRUE(HasEnded(second_watch));
  EXPECT_FALSE(guard_.MayTake());
  Turn(0);
  EXPECT_TRUE(guard_.MayTake());
}

TEST_F(ConnectionGuardTest, SparesThoseWhoseCallsWereLetIn) {
  const TcpPair pair;
  const int watch = Add(pair);
  connections_.NoteCall(LastPeer(), ConnectionRegistry::Call::kLetIn, 100);
  Send(pair, 50'000);
  for (int turn = 0; turn < 5; ++turn) Turn(kMuch);
  EXPECT_FALSE(HasEnded(watch));
}

// A call of a few bytes may hold much, and there may be many who make them.
TEST_F(ConnectionGuardTest, SparesNotManyWhoHaveSentLittleWhileMemoryIsCritical) {
  constexpr size_t kEach = 1'024, kPairs = 40;
  const TcpPair pairs[kPairs];
  const std::vector<int> watches = AddSending(pairs, kEach);
  Turn(kMuch);
  EXPECT_EQ(CountEnded(watches), 0) << "what was freed goes first";
  Turn(kMuch);
  EXPECT_EQ(CountEnded(watches), kPairs - ConnectionGuard::kSparedTogether / kEach);
  EXPECT_FALSE(guard_.MayTake());
}

TEST_F(ConnectionGuardTest, SparesFewerWhoHaveSentLittleWhileMemoryIsHigh) {
  constexpr size_t kEach = ConnectionRegistry::kSparedBytes, kPairs = 24;
  const TcpPair pairs[kPairs];
  const std::vector<int> watches = AddSending(pairs, kEach);
  const uint64_t high = kLimit + MemoryPressure::kHighBytes + 1;
  Turn(high - 1);
  Turn(high);
  EXPECT_EQ(CountEnded(watches), 0) << "what was freed goes first";
  Turn(high);
  EXPECT_EQ(CountEnded(watches), kPairs - ConnectionGuard::kStrangersTogether / kEach);
  EXPECT_TRUE(guard_.MayTake());
}

TEST_F(ConnectionGuardTest, EndsWhoWasLetInOnlyIfGivingBackWhatWasFreedDoesNotHelp) {
  const TcpPair pair;
  const int watch = Add(pair);
  connections_.NoteCall(LastPeer(), ConnectionRegistry::Call::kLetIn, 100);
  // Within what may be unaccounted for, but much.
  for (size_t sent = 0; sent < ConnectionGuard::kSparedLetInBytes + 20'000; sent += 4'096) SendAndRead(pair, 4'096);
  Turn(kMuch);
  EXPECT_FALSE(HasEnded(watch));
  Turn(kMuch);
  EXPECT_TRUE(HasEnded(watch));
}

TEST_F(ConnectionGuardTest, TheSystemHoldsStrangersToWhatTheMemoryThatIsLeftCanBear) {
  const uint64_t least = ByteAllowances().strangers_together();
  for (const auto& [resident, most] :
       {std::pair{uint64_t{0}, (kLimit + MemoryPressure::kHighBytes) / ConnectionGuard::kWorstGrowth},
        std::pair{kLimit + MemoryPressure::kHighBytes, least}}) {
    guard_.ShareAmongStrangers(resident);
    constexpr size_t kPairs = 24, kEach = 50'000;
    const TcpPair pairs[kPairs];
    const std::vector<int> watches = AddSending(pairs, kEach);
    uint64_t received = 0;
    for (const int watch : watches) received += connections_.Remove(watch).received_bytes;
    // Those who wait at the door have sent what a newcomer needs.
    EXPECT_LE(received, most + kPairs * (StrangerRations::kGreetingBytes + StrangerRations::kNewcomerBytes));
    EXPECT_GE(received, most / 2);
    for (const int watch : watches) guard_.Forget(watch);
    now_ += StrangerRations::kAftermath;
    connections_.DivideAmongStrangers(now_);
  }
}

}  // namespace
}  // namespace curvd
