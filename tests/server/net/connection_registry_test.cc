#include "server/net/connection_registry.h"

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/server/net/socket_pair.h"

namespace curvd {
namespace {

using Call = ConnectionRegistry::Call;

// Whether `watch` shows that its connection has ended, after waiting for it for at most `wait_ms`.
bool HasEnded(int watch, int wait_ms) {
  pollfd ended = {watch, 0, 0};
  return poll(&ended, 1, wait_ms) == 1 && (ended.revents & POLLHUP) != 0;
}

constexpr int kWaitMs = 60'000;

TEST(ConnectionRegistryTest, CountsConnectionsByAddressWhateverTheirPorts) {
  ConnectionRegistry connections;
  const TcpPair first, second, third;
  const int watch = connections.Add(first.server(), "ipv4:10.0.0.7:1")->watch;
  connections.Add(second.server(), "ipv4:10.0.0.7:2");
  connections.Add(third.server(), "ipv6:%5B2001:db8::1%5D:3");
  EXPECT_EQ(connections.size(), 3u);
  EXPECT_EQ(connections.CountFrom("10.0.0.7"), 2u);
  EXPECT_EQ(connections.CountFrom("2001:db8::/64"), 1u);
  EXPECT_EQ(connections.CountFrom("10.0.0.8"), 0u);
  EXPECT_EQ(connections.Remove(watch).peer, "ipv4:10.0.0.7:1");
  EXPECT_EQ(connections.size(), 2u);
  EXPECT_EQ(connections.CountFrom("10.0.0.7"), 1u);
  connections.Clear();
  EXPECT_EQ(connections.size(), 0u);
  EXPECT_EQ(connections.CountFrom("10.0.0.7"), 0u);
}

TEST(ConnectionRegistryTest, TheWatchShowsThatTheServerClosedTheConnection) {
  ConnectionRegistry connections;
  TcpPair pair;
  const int watch = connections.Add(pair.server(), "ipv4:10.0.0.7:1")->watch;
  EXPECT_FALSE(HasEnded(watch, 0));
  pair.ShutDownAndCloseServer();
  EXPECT_TRUE(HasEnded(watch, kWaitMs));
  char byte;
  EXPECT_EQ(recv(pair.client(), &byte, 1, 0), 0);  // the client has been told, although the watch is open
}

TEST(ConnectionRegistryTest, TheWatchShowsThatTheClientBrokeTheConnectionOff) {
  ConnectionRegistry connections;
  const TcpPair pair;
  const int watch = connections.Add(pair.server(), "ipv4:10.0.0.7:1")->watch;
  ASSERT_EQ(send(pair.server(), "x", 1, 0), 1);
  const linger at_once = {1, 0};  // a reset in place of an end
  setsockopt(pair.client(), SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  shutdown(pair.client(), SHUT_WR);
  EXPECT_FALSE(HasEnded(watch, 0));  // half of it is left
  EXPECT_EQ(shutdown(watch, SHUT_RDWR), 0);
  EXPECT_TRUE(HasEnded(watch, kWaitMs));
}

TEST(ConnectionRegistryTest, TellsWhatAConnectionHasSentAndWhatOfItWasLetIn) {
  ConnectionRegistry connections;
  const TcpPair pair, silent;
  const int watch = connections.Add(pair.server(), "ipv4:10.0.0.7:1")->watch;
  ASSERT_EQ(send(pair.client(), "12345678", 8, 0), 8);
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kRefused, 0);
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kLetIn, 0);
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kLetIn, 0);
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kOpenToAll, 0);
  connections.NoteMessage("ipv4:10.0.0.7:1", 2, true);
  connections.NoteMessage("ipv4:10.0.0.7:1", 3, false);
  connections.NoteCall("inproc", Call::kLetIn, 0);  // no connection
  connections.NoteMessage("inproc", 7, true);
  const auto open = connections.Open();
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open.front().received_bytes, 8u);
  const ConnectionRecord record = connections.Remove(watch);
  EXPECT_EQ(record.received_bytes, 8u);
  EXPECT_EQ(record.let_in_bytes, 5u);
  EXPECT_EQ(record.let_in_calls, 2u);
  EXPECT_EQ(record.refused_calls, 1u);
  EXPECT_EQ(record.open_calls, 1u);
}

TEST(ConnectionRegistryTest, KnowsWhetherBytesCameSinceTheLastLook) {
  ConnectionRegistry connections;
  const TcpPair pair;
  const int watch = connections.Add(pair.server(), "ipv4:10.0.0.7:1")->watch;
  EXPECT_FALSE(connections.HasMore(watch));
  ASSERT_EQ(send(pair.client(), "12345678", 8, 0), 8);
  char bytes[8];
  ASSERT_EQ(recv(pair.server(), bytes, sizeof(bytes), MSG_WAITALL), 8);
  EXPECT_TRUE(connections.HasMore(watch));
  connections.Look(watch, std::chrono::steady_clock::now());
  EXPECT_FALSE(connections.HasMore(watch));
}

TEST(ConnectionRegistryTest, APeerThatCameAgainIsTheNewConnection) {
  ConnectionRegistry connections;
  const TcpPair old_pair, new_pair;
  const int old_watch = connections.Add(old_pair.server(), "ipv4:10.0.0.7:1")->watch;
  const int new_watch = connections.Add(new_pair.server(), "ipv4:10.0.0.7:1")->watch;  // before the old end was noticed
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kLetIn, 0);
  EXPECT_EQ(connections.Remove(old_watch).let_in_calls, 0u);
  connections.NoteCall("ipv4:10.0.0.7:1", Call::kLetIn, 0);
  EXPECT_EQ(connections.Remove(new_watch).let_in_calls, 2u);
}

}  // namespace
}  // namespace curvd
