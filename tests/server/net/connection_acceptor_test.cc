#include "server/net/connection_acceptor.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <future>
#include <utility>

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

// A peer that froze with results on their way cannot be asked whether it lives: the system has to give up on it.
TEST(ConnectionAcceptorTest, TheSystemGivesUpOnPeersThatTakeNothing) {
  auto sockets = ListeningSockets::Bind("listen", "127.0.0.1:0");
  ASSERT_TRUE(sockets.ok()) << sockets.status();
  ConnectionAcceptor acceptor(*std::move(sockets), {1, 1}, nullptr);
  std::promise<int> taken;
  acceptor.Start(std::make_unique<Target>(taken));

  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(acceptor.port()));
  const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(connect(client, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  const int server = taken.get_future().get();

  int patience_ms = 0;
  socklen_t length = sizeof(patience_ms);
  EXPECT_EQ(getsockopt(server, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, &length), 0);
  EXPECT_EQ(patience_ms, kKeepaliveTimeMs + kKeepaliveTimeoutMs);
  close(client);
  close(server);
}

}  // namespace
}  // namespace curvd
