#include "server/net/connection_table.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace curvd {
namespace {

int NewSocket() { return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }

// A TCP connection over loopback; both ends are closed on destruction.
class TcpPair {
 public:
  TcpPair() {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    auto* any = reinterpret_cast<sockaddr*>(&address);
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(listener, any, length), 0);
    EXPECT_EQ(listen(listener, 1), 0);
    EXPECT_EQ(getsockname(listener, any, &length), 0);
    client_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(connect(client_, any, length), 0);
    server_ = accept(listener, nullptr, nullptr);
    close(listener);
  }
  ~TcpPair() {
    close(client_);
    close(server_);
  }
  TcpPair(const TcpPair&) = delete;
  TcpPair& operator=(const TcpPair&) = delete;

  int server() const { return server_; }
  void ShutDownServer() const { shutdown(server_, SHUT_RDWR); }
  void ShutDownClient() const { shutdown(client_, SHUT_RDWR); }

 private:
  int client_;
  int server_;
};

TEST(ConnectionTableTest, CountsWhatIsOpenByPeer) {
  ConnectionTable table;
  const int first = NewSocket(), second = NewSocket(), third = NewSocket();
  table.Add(first, "a");
  table.Add(second, "a");
  table.Add(third, "b");
  table.Sweep();
  EXPECT_EQ(table.size(), 3u);
  EXPECT_EQ(table.CountOf("a"), 2u);
  EXPECT_EQ(table.CountOf("b"), 1u);
  EXPECT_EQ(table.CountOf("c"), 0u);
  close(second);
  table.Sweep();
  EXPECT_EQ(table.size(), 2u);
  EXPECT_EQ(table.CountOf("a"), 1u);
  close(first);
  close(third);
  table.Sweep();
  EXPECT_EQ(table.size(), 0u);
}

TEST(ConnectionTableTest, KnowsADescriptorThatWasGivenToAnotherFile) {
  ConnectionTable table;
  const int first = NewSocket();
  table.Add(first, "a");
  const int other = NewSocket();
  ASSERT_EQ(dup2(other, first), first);  // closes the socket, and the number is in use again
  table.Sweep();
  EXPECT_EQ(table.size(), 0u);
  table.Add(first, "a");
  table.Add(first, "b");  // closed and accepted again without a sweep between
  EXPECT_EQ(table.size(), 1u);
  EXPECT_EQ(table.CountOf("a"), 0u);
  EXPECT_EQ(table.CountOf("b"), 1u);
  close(first);
  close(other);
}

TEST(ConnectionTableTest, CountsAnAddressWhateverItsPorts) {
  ConnectionTable table;
  const int first = NewSocket(), second = NewSocket();
  table.Add(first, "ipv4:10.0.0.7:1");
  table.Add(second, "ipv4:10.0.0.7:2");
  EXPECT_EQ(table.CountOf("10.0.0.7"), 2u);
  close(first);
  close(second);
  table.Sweep();
  EXPECT_EQ(table.CountOf("10.0.0.7"), 0u);
}

TEST(ConnectionTableTest, NamesTheOneConnectionThatIsBeingClosed) {
  ConnectionTable table;
  const TcpPair open, left_by_client, first, second;
  table.Add(open.server(), "ipv4:10.0.0.1:1");
  table.Add(left_by_client.server(), "ipv4:10.0.0.2:2");
  table.Add(first.server(), "ipv4:10.0.0.3:3");
  table.Add(second.server(), "ipv4:10.0.0.4:4");
  left_by_client.ShutDownClient();
  EXPECT_EQ(table.PeerBeingClosed(), "");
  first.ShutDownServer();
  EXPECT_EQ(table.PeerBeingClosed(), "ipv4:10.0.0.3:3");
  second.ShutDownServer();
  EXPECT_EQ(table.PeerBeingClosed(), "");  // either may be meant
}

}  // namespace
}  // namespace curvd
