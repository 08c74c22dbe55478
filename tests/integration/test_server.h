// A server in this process, on ports that the system picked.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <string>

#include "server/curvature_server.h"

namespace curvd {

class TestServer {
 public:
  // Loopback, two threads, a metrics port, no log; `change` may alter that. Fails the test if it cannot start.
  explicit TestServer(const std::function<void(ServerOptions&)>& change = nullptr);

  CurvatureServer& server() { return *server_; }
  const std::string& address() const { return address_; }
  // A channel of its own, so that tests do not share connections.
  std::shared_ptr<grpc::Channel> NewChannel() const;
  // What a scrape returns now.
  std::string Scrape() const;
  // The value of the series that is written as `series` in a scrape; -1 if there is none.
  double Metric(const std::string& series) const;
  // Scrapes until the series has `value`; fails the test after a minute.
  void WaitForMetric(const std::string& series, double value) const;
  // Until no call is open and no memory is reserved.
  void WaitUntilIdle() const;

 private:
  std::unique_ptr<CurvatureServer> server_;
  std::string address_;
};

// The answer to a GET, headers included.
std::string HttpGet(int port, const std::string& path);

// The value of the series that is written as `series` in a scrape of `port`; -1 if there is none.
double MetricOf(int port, const std::string& series);
// Scrapes until `wanted` is true of the series' value; fails the test after a minute.
void WaitForMetricOf(int port, const std::string& series, const std::function<bool(double)>& wanted);

// `address` as clients of curvd are told to set their channels up.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address);

}  // namespace curvd
