#include "server/net/strangers.h"

#include <gtest/gtest.h>

#include <string>

namespace curvd {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr auto kHandshakeTimeout = seconds(10);
constexpr auto kSoon = milliseconds(30);

ConnectionRecord Connection(uint64_t received_bytes) {
  ConnectionRecord connection;
  connection.peer = "ipv4:10.0.0.7:1";
  connection.received_bytes = received_bytes;
  return connection;
}

TEST(WhyStrangerTest, WhoMadeACallThatWasLetInIsNone) {
  ConnectionRecord connection = Connection(5'000);
  connection.let_in_calls = 1;
  connection.refused_calls = 7;
  EXPECT_EQ(WhyStranger(connection, kSoon, kHandshakeTimeout), std::nullopt);
  EXPECT_EQ(WhyStranger(connection, kHandshakeTimeout, kHandshakeTimeout), std::nullopt);
}

TEST(WhyStrangerTest, WhoAskedForHealthIsNone) {
  ConnectionRecord connection = Connection(300);
  connection.open_calls = 1;
  EXPECT_EQ(WhyStranger(connection, kSoon, kHandshakeTimeout), std::nullopt);
}

TEST(WhyStrangerTest, UnixSocketsHaveNone) {
  ConnectionRecord connection = Connection(0);
  connection.peer = "unix:";
  EXPECT_EQ(WhyStranger(connection, kSoon, kHandshakeTimeout), std::nullopt);
}

TEST(WhyStrangerTest, WhoseCallsWereAllRefusedIsOne) {
  ConnectionRecord connection = Connection(5'000);
  connection.refused_calls = 2;
  EXPECT_EQ(WhyStranger(connection, kHandshakeTimeout, kHandshakeTimeout), StrangerReason::kNotLetIn);
}

TEST(WhyStrangerTest, TheEndOfWhatAPeerSendsCountsForNothing) {
  EXPECT_EQ(WhyStranger(Connection(0), kSoon, kHandshakeTimeout), StrangerReason::kNothingSent);
  EXPECT_EQ(WhyStranger(Connection(1), kSoon, kHandshakeTimeout), StrangerReason::kNothingSent);
  EXPECT_EQ(WhyStranger(Connection(2), kSoon, kHandshakeTimeout), StrangerReason::kNoCall);
}

TEST(WhyStrangerTest, TheAgeTellsOfAHandshakeThatTookTooLong) {
  for (const uint64_t bytes : {0, 500}) {
    const ConnectionRecord connection = Connection(bytes);
    EXPECT_NE(WhyStranger(connection, kHandshakeTimeout - kSoon, kHandshakeTimeout), StrangerReason::kHandshakeTimeout);
    EXPECT_EQ(WhyStranger(connection, kHandshakeTimeout + kSoon, kHandshakeTimeout), StrangerReason::kHandshakeTimeout);
    EXPECT_NE(WhyStranger(connection, kHandshakeTimeout + seconds(60), kHandshakeTimeout),
              StrangerReason::kHandshakeTimeout);
  }
}

}  // namespace
}  // namespace curvd
