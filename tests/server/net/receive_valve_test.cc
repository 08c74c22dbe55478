#include "server/net/receive_valve.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <string>

#include "tests/server/net/socket_pair.h"

namespace curvd {
namespace {

constexpr int kReadMs = 60'000;

// Reads `count` bytes at least, and all that there are then.
std::string ReadAtLeast(int fd, size_t count) {
  std::string all;
  std::string part(1 << 20, '\0');
  while (all.size() < count) {
    pollfd readable = {fd, POLLIN, 0};
    if (poll(&readable, 1, kReadMs) != 1) break;
    const ssize_t got = recv(fd, part.data(), part.size(), MSG_DONTWAIT);
    if (got <= 0) break;
    all.append(part, 0, static_cast<size_t>(got));
  }
  return all;
}

bool IsReadable(int fd) {
  pollfd readable = {fd, POLLIN, 0};
  return poll(&readable, 1, 0) == 1;
}

std::string Letters(size_t count) {
  std::string letters(count, '\0');
  for (size_t i = 0; i < count; ++i) letters[i] = static_cast<char>('a' + i % 26);
  return letters;
}

TEST(ReceiveValveTest, LetsThroughWhatLiesBeforeTheBound) {
  const TcpPair pair;
  const std::optional<uint32_t> beginning = BeginningOf(pair.server());
  ASSERT_TRUE(beginning.has_value());
  ASSERT_TRUE(BoundReceived(pair.server(), *beginning, 1'000));
  const std::string sent = Letters(5'000);
  ASSERT_EQ(send(pair.client(), sent.data(), sent.size(), 0), 5'000);
  EXPECT_EQ(ReadAtLeast(pair.server(), 1'000), sent.substr(0, 1'000));
  EXPECT_FALSE(IsReadable(pair.server()));  // loopback delivers before send returns
}

TEST(ReceiveValveTest, WhatWasCutOffComesOnceTheBoundMoves) {
  const TcpPair pair;
  const std::optional<uint32_t> beginning = BeginningOf(pair.server());
  ASSERT_TRUE(beginning.has_value());
  ASSERT_TRUE(BoundReceived(pair.server(), *beginning, 1'000));
  const std::string sent = Letters(5'000);
  ASSERT_EQ(send(pair.client(), sent.data(), sent.size(), 0), 5'000);
  ASSERT_TRUE(BoundReceived(pair.server(), *beginning, 3'000));
  EXPECT_EQ(ReadAtLeast(pair.server(), 3'000), sent.substr(0, 3'000));
  LiftBound(pair.server());
  EXPECT_EQ(ReadAtLeast(pair.server(), 2'000), sent.substr(3'000));
}

TEST(ReceiveValveTest, KnowsNoBeginningOfSocketsThatAreNotTcp) {
  int pair[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
  EXPECT_FALSE(BeginningOf(pair[0]).has_value());
  close(pair[0]);
  close(pair[1]);
}

}  // namespace
}  // namespace curvd
