#include "server/net/metrics_port.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/observe/server_metrics.h"

namespace curvd {
namespace {

TEST(MetricsPortTest, PicksAFreePort) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto port = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(port.ok()) << port.status();
  EXPECT_GT((*port)->port(), 0);
}

// Connects to a port of this machine and sends `request`.
int Send(int port, const std::string& request) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_EQ(send(fd, request.data(), request.size(), 0), static_cast<ssize_t>(request.size()));
  return fd;
}

TEST(MetricsPortTest, AnswersWithinAScrapesTimeBesideRequestsThatNeverEnd) {
  constexpr int kScrapeTimeoutMs = 10'000;  // Prometheus' default
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto port = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(port.ok()) << port.status();
  std::vector<int> connections;
  for (int i = 0; i < 60; ++i) connections.push_back(Send((*port)->port(), "GET /metrics HTTP/1.1\r\nHost:"));
  connections.push_back(Send((*port)->port(), "GET /metrics HTTP/1.0\r\n\r\n"));
  pollfd answered = {connections.back(), POLLIN, 0};
  EXPECT_EQ(poll(&answered, 1, kScrapeTimeoutMs), 1);
  char status[13] = "";
  EXPECT_EQ(recv(connections.back(), status, 12, MSG_WAITALL), 12);
  EXPECT_STREQ(status + 8, " 200");
  for (const int fd : connections) close(fd);
}

// What a port answers, to the end of the connection.
std::string Answer(int port, const std::string& request) {
  const int fd = Send(port, request);
  std::string answer;
  char bytes[4096];
  for (ssize_t got = 0; (got = recv(fd, bytes, sizeof(bytes), 0)) > 0;) answer.append(bytes, static_cast<size_t>(got));
  close(fd);
  return answer;
}

TEST(MetricsPortTest, AnswersHeadAsGetWithoutABody) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto port = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(port.ok()) << port.status();
  const std::string head = Answer((*port)->port(), "HEAD /metrics HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_THAT(head, ::testing::StartsWith("HTTP/1.1 200 OK\r\nContent-Type: text/plain; charset=utf-8\r\n"));
  EXPECT_THAT(head, ::testing::EndsWith("\r\n\r\n"));
  EXPECT_THAT(Answer((*port)->port(), "GET /metrics HTTP/1.0\r\n\r\n"), ::testing::HasSubstr("curvd_streams_open"));
}

TEST(MetricsPortTest, SaysWhichMethodsItTakes) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto port = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(port.ok()) << port.status();
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"}) {
    const std::string answer =
        Answer((*port)->port(), absl::StrCat(method, " /metrics HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\nab"));
    EXPECT_THAT(answer, ::testing::StartsWith("HTTP/1.1 405 ")) << method;
    EXPECT_THAT(answer, ::testing::HasSubstr("Allow: GET, HEAD\r\n")) << method;
  }
  EXPECT_THAT(Answer((*port)->port(), "HEAD /other HTTP/1.1\r\nHost: a\r\n\r\n"),
              ::testing::StartsWith("HTTP/1.1 404 "));
}

TEST(MetricsPortTest, NamesAnAddressThatItCannotBind) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto first = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(first.ok());
  const std::string address = absl::StrCat("127.0.0.1:", (*first)->port());
  for (const std::string& listen : {address, std::string("no address")}) {
    const auto second = MetricsPort::Create(listen, metrics.collectables());
    EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(std::string(second.status().message()), ::testing::HasSubstr(listen));
  }
}

}  // namespace
}  // namespace curvd
