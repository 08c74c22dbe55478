#include "server/net/listen_address.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

TEST(IsLocalAddressTest, KnowsLoopbackAndUnixSockets) {
  for (const char* listen : {"", "unix:/run/curvd.sock", "localhost:1", "127.0.0.1:0", "127.9.9.9:1", "[::1]:1"}) {
    EXPECT_TRUE(IsLocalAddress(listen)) << listen;
  }
}

TEST(IsLocalAddressTest, TakesEverythingElseForPublic) {
  for (const char* listen : {"0.0.0.0:1", "[::]:1", "10.0.0.7:1", "127.0.0.1.example.com:1", "localhost.example.com:1",
                             "[::ffff:10.0.0.7]:1", ":1", "dns:localhost:1", "nonsense"}) {
    EXPECT_FALSE(IsLocalAddress(listen)) << listen;
  }
}

TEST(PeerAddressTest, IsTheAddressWithoutThePort) {
  EXPECT_EQ(PeerAddress("ipv4:10.0.0.7:1234"), "10.0.0.7");
  EXPECT_EQ(PeerAddress("ipv6:[::ffff:10.0.0.7]:1234"), "10.0.0.7");
  EXPECT_EQ(PeerAddress("unix:"), "unix");
  EXPECT_EQ(PeerAddress("unix:/run/curvd.sock"), "unix");
  EXPECT_EQ(PeerAddress("inproc"), "inproc");
}

TEST(PeerAddressTest, CountsAllOfAnIpv6SubscriberAsOne) {
  EXPECT_EQ(PeerAddress("ipv6:[2001:db8:1:2:3:4:5:6]:80"), "2001:db8:1:2::/64");
  EXPECT_EQ(PeerAddress("ipv6:%5B2001:db8:1:2:ffff::1%5D:80"), "2001:db8:1:2::/64");
  EXPECT_EQ(PeerAddress("ipv6:%5Bfe80::1%25eth0%5D:80"), "fe80::/64");
}

}  // namespace
}  // namespace curvd
