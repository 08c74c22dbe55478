// Whether peers are asked if they are there, by raw HTTP/2: those with a call are, those without are left alone.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "tests/integration/raw_connections.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

using std::chrono::milliseconds;

constexpr char kPing = 6;

// An HTTP/2 frame of fewer than 256 bytes on stream `stream`.
std::string Frame(char type, char flags, char stream, const std::string& payload) {
  const std::string head = {0, 0, static_cast<char>(payload.size()), type, flags, 0, 0, 0, stream};
  return head + payload;
}

// What a client sends first: the preface and its settings, which are the defaults.
std::string Hello() { return absl::StrCat("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", Frame(4, 0, 0, "")); }

std::string Header(const std::string& name, const std::string& value) {
  return absl::StrCat(std::string(1, '\0'), std::string(1, static_cast<char>(name.size())), name,
                      std::string(1, static_cast<char>(value.size())), value);
}

// The headers of a call whose messages never come.
std::string OpenCall() {
  return Frame(1, 4, 1,
               absl::StrCat(Header(":method", "POST"), Header(":scheme", "http"), Header(":authority", "curvd"),
                            Header(":path", "/curvature.v1.CurvatureService/EstimateCurvature"),
                            Header("content-type", "application/grpc"), Header("te", "trailers")));
}

bool HasFrame(const std::string& bytes, char type) {
  for (size_t at = 0; at + 9 <= bytes.size();) {
    if (bytes[at + 3] == type) return true;
    const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(bytes[at + i])); };
    at += 9 + (byte(0) << 16 | byte(1) << 8 | byte(2));
  }
  return false;
}

class KeepaliveTest : public ::testing::Test {
 protected:
  TestServer server_{[](ServerOptions& options) {
    options.keepalive_time = absl::Milliseconds(50);
    options.keepalive_timeout = absl::Milliseconds(50);
  }};
};

// A process with many idle channels could not answer in time, and would lose them all.
TEST_F(KeepaliveTest, AConnectionWithoutACallIsLeftAlone) {
  const RawConnections client("127.0.0.1", server_.server().port(), 1);
  client.Send(Hello());
  const std::string received = client.ReadFor(milliseconds(1'000));  // ten times what it would take
  EXPECT_FALSE(received.empty());
  EXPECT_FALSE(HasFrame(received, kPing));
  EXPECT_EQ(client.CountOpen(), 1u);
}

TEST_F(KeepaliveTest, AConnectionWithACallEndsIfItsPeerDoesNotAnswer) {
  const RawConnections client("127.0.0.1", server_.server().port(), 1);
  client.Send(Hello() + OpenCall());
  const std::string received = client.ReadFor(milliseconds(60'000));
  EXPECT_TRUE(HasFrame(received, kPing));
  EXPECT_EQ(client.CountOpen(), 0u);
  server_.WaitUntilIdle();
}

}  // namespace
}  // namespace curvd
