#include "server/connection_table.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace curvd {
namespace {

int NewSocket() { return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }

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

}  // namespace
}  // namespace curvd
