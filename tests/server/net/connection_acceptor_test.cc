#include "server/net/connection_acceptor.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "server/net/keepalive.h"

namespace curvd {
namespace {

// Keeps the first connection that it is given.
class Target final : public grpc::experimental::ExternalConnectionAcceptor {
 public:
  explicit Target(std::promise<int>& taken) : taken_(taken) {}
  void HandleNewConnection(NewConnectionParameters* connection) override { taken_.set_value(connection->fd); }

 private:
  std::promise<int>& taken_;
};

int ConnectTo(int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  EXPECT_EQ(connect(client, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  return client;
}

int OptionOf(int fd, int level, int option) {
  int value = -1;
  socklen_t length = sizeof(value);
  EXPECT_EQ(getsockopt(fd, level, option, &value, &length), 0);
  return value;
}

// An acceptor for one connection at a time, that was given one.
class ConnectionAcceptorTest : public ::testing::Test {
 protected:
  ConnectionAcceptorTest() {
    acceptor_.Start(std::make_unique<Target>(taken_));
    client_ = ConnectTo(acceptor_.port());
    server_ = taken_.get_future().get();
  }
  ~ConnectionAcceptorTest() override {
    close(client_);
    if (server_ >= 0) close(server_);
  }

  std::promise<int> taken_;
  std::promise<std::string> refused_;
  std::promise<ConnectionRecord> ended_;
  ConnectionRegistry connections_;
  MemoryPressure memory_{uint64_t{1} << 40};
  ConnectionAcceptor acceptor_{*ListeningSockets::Bind("listen", "127.0.0.1:0"),
                               {1, 1},
                               connections_,
                               memory_,
                               {[this](StrangerReason reason, const std::string& peer) {
                                  refused_.set_value(StrangerReasonName(reason) + (" " + peer));
                                },
                                [this](const ConnectionRecord& connection, std::chrono::steady_clock::duration) {
                                  ended_.set_value(connection);
                                }}};
  int client_ = -1;
  int server_ = -1;
};

// A peer that froze with results on their way cannot be asked whether it lives: the system has to give up on it.
TEST_F(ConnectionAcceptorTest, TheSystemGivesUpOnPeersThatTakeNothing) {
  EXPECT_EQ(OptionOf(server_, IPPROTO_TCP, TCP_USER_TIMEOUT), kKeepaliveTimeMs + kKeepaliveTimeoutMs);
}

TEST_F(ConnectionAcceptorTest, TheSystemAsksWhetherIdlePeersAreThere) {
  EXPECT_EQ(OptionOf(server_, SOL_SOCKET, SO_KEEPALIVE), 1);
  EXPECT_EQ(OptionOf(server_, IPPROTO_TCP, TCP_KEEPIDLE), kKeepaliveTimeMs / 1000);
  EXPECT_EQ(OptionOf(server_, IPPROTO_TCP, TCP_KEEPINTVL), kKeepaliveTimeoutMs / 1000);
}

TEST_F(ConnectionAcceptorTest, RefusesConnectionsOverALimit) {
  const int second = ConnectTo(acceptor_.port());
  EXPECT_TRUE(absl::StartsWith(refused_.get_future().get(), "connection_limit ipv4:127.0.0.1:"));
  EXPECT_EQ(connections_.size(), 1u);
  close(second);
}

TEST_F(ConnectionAcceptorTest, TellsWhenGrpcHasClosedAConnection) {
  ASSERT_EQ(send(client_, "four", 4, 0), 4);
  shutdown(server_, SHUT_RDWR);
  close(std::exchange(server_, -1));
  const ConnectionRecord connection = ended_.get_future().get();
  EXPECT_TRUE(absl::StartsWith(connection.peer, "ipv4:127.0.0.1:"));
  EXPECT_EQ(connection.received_bytes, 4u);
  EXPECT_EQ(connections_.size(), 0u);
}

// gRPC may be faster than the acceptor's thread, which finds nothing left to read then.
TEST(ConnectionAcceptorThreadTest, NoticesBytesThatGrpcHasReadBeforeItLooks) {
  std::promise<int> taken;
  std::promise<void> is_busy, may_go_on;
  std::promise<ConnectionRecord> ended;
  ConnectionRegistry connections({.stranger = 32 << 10});
  MemoryPressure memory(MemoryPressure::kAnyLimit);
  ConnectionAcceptor acceptor(
      *ListeningSockets::Bind("listen", "127.0.0.1:0"), {1, 1}, connections, memory,
      {[&](StrangerReason, const std::string&) {
         is_busy.set_value();
         may_go_on.get_future().wait();
       },
       [&](const ConnectionRecord& connection, std::chrono::steady_clock::duration) { ended.set_value(connection); }});
  acceptor.Start(std::make_unique<Target>(taken));
  const int client = ConnectTo(acceptor.port());
  const int server = taken.get_future().get();
  const int refused = ConnectTo(acceptor.port());
  is_busy.get_future().wait();
  std::string bytes(30'000, 'x');
  ASSERT_EQ(send(client, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  ASSERT_EQ(recv(server, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  may_go_on.set_value();
  std::future<ConnectionRecord> connection = ended.get_future();
  const bool has_ended = connection.wait_for(std::chrono::minutes(1)) == std::future_status::ready;
  EXPECT_TRUE(has_ended);
  if (has_ended) {
    EXPECT_EQ(connection.get().closed_for, StrangerReason::kUnaccountedBytes);
  }
  for (const int fd : {client, server, refused}) close(fd);
}

// gRPC reads whatever the system has received, so it must not get the connection before there is memory for that.
TEST(ConnectionAcceptorThreadTest, KeepsAtTheDoorWhoSentMoreThanThereIsMemoryFor) {
  std::promise<int> first_taken, second_taken;
  class Pair final : public grpc::experimental::ExternalConnectionAcceptor {
   public:
    Pair(std::promise<int>& first, std::promise<int>& second) : taken_{&first, &second} {}
    void HandleNewConnection(NewConnectionParameters* connection) override {
      taken_.at(count_++)->set_value(connection->fd);
    }

   private:
    std::array<std::promise<int>*, 2> taken_;
    size_t count_ = 0;
  };
  ConnectionRegistry connections;
  // Strangers together may send 28 KB, of which a part is for newcomers.
  MemoryPressure memory(ResidentBytes());
  ConnectionAcceptor acceptor(*ListeningSockets::Bind("listen", "127.0.0.1:0"), {2, 2}, connections, memory, {});
  const std::string bytes(12'000, 'x');
  const int clients[] = {ConnectTo(acceptor.port()), ConnectTo(acceptor.port())};
  for (const int client : clients) {
    ASSERT_EQ(send(client, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  }
  acceptor.Start(std::make_unique<Pair>(first_taken, second_taken));
  const int first = first_taken.get_future().get();
  std::future<int> second = second_taken.get_future();
  EXPECT_EQ(second.wait_for(std::chrono::milliseconds(30)), std::future_status::timeout);
  shutdown(first, SHUT_RDWR);
  EXPECT_EQ(second.wait_for(std::chrono::minutes(1)), std::future_status::ready);
  acceptor.Stop();
  for (const int fd : {clients[0], clients[1], first, second.get()}) close(fd);
}

TEST_F(ConnectionAcceptorTest, ForgetsConnectionsWhenItStops) {
  acceptor_.Stop();
  EXPECT_EQ(connections_.size(), 0u);
  EXPECT_EQ(send(server_, "x", 1, 0), 1);  // it is open all the same
}

}  // namespace
}  // namespace curvd
