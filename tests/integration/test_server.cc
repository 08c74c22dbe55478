#include "tests/integration/test_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "absl/strings/str_cat.h"

namespace curvd {

TestServer::TestServer(const std::function<void(ServerOptions&)>& change) {
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.metrics_listen = "127.0.0.1:0";
  options.threads = 2;
  options.log = false;
  if (change) change(options);
  absl::StatusOr<std::unique_ptr<CurvatureServer>> server = CurvatureServer::Create(options);
  EXPECT_TRUE(server.ok()) << server.status();
  if (!server.ok()) std::abort();
  server_ = *std::move(server);
  address_ = absl::StrCat("127.0.0.1:", server_->port());
}

std::shared_ptr<grpc::Channel> TestServer::NewChannel() const { return OpenChannel(address_); }

std::string TestServer::Scrape() const { return HttpGet(server_->metrics_port(), "/metrics"); }

double TestServer::Metric(const std::string& series) const { return MetricOf(server_->metrics_port(), series); }

void TestServer::WaitForMetric(const std::string& series, double value) const {
  WaitForMetricOf(server_->metrics_port(), series, [value](double now) { return now == value; });
}

void TestServer::WaitUntilIdle() const {
  WaitForMetric("curvd_streams_open", 0);
  WaitForMetric("curvd_memory_reserved_bytes", 0);
  WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 0);
  WaitForMetric("curvd_workers_busy", 0);
}

std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

double MetricOf(int port, const std::string& series) {
  const std::string text = HttpGet(port, "/metrics");
  const size_t found = text.find("\n" + series + " ");
  return found == std::string::npos ? -1.0 : std::atof(text.c_str() + found + series.size() + 2);
}

void WaitForMetricOf(int port, const std::string& series, const std::function<bool(double)>& wanted) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  double last = -1.0;
  while (std::chrono::steady_clock::now() < deadline) {
    last = MetricOf(port, series);
    if (wanted(last)) return;
  }
  ADD_FAILURE() << series << " is still " << last << " after a minute";
}

std::string HttpGet(int port, const std::string& path) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
    const std::string request = absl::StrCat("GET ", path, " HTTP/1.0\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
    char buffer[65'536];
    ssize_t count = 0;
    while ((count = read(fd, buffer, sizeof(buffer))) > 0) answer.append(buffer, static_cast<size_t>(count));
  }
  close(fd);
  return answer;
}

}  // namespace curvd
