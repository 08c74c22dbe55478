// A server of one's own, as an operator runs it: a process on a free loopback port.
#pragma once

#include <sys/types.h>
#include <time.h>

#include <cstdio>
#include <string>
#include <vector>

namespace curvd::bench {

// Ends the program if the server does not start. Not thread-safe.
class ServerProcess {
 public:
  static ServerProcess Curvd(int threads);
  static ServerProcess Bare(int threads);  // bench/bare_server.cc
  ~ServerProcess();                        // ends the server
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  const std::string& address() const { return address_; }
  // CPU seconds of all its threads since it started.
  double CpuSeconds() const;
  // Most memory that it ever had resident, in bytes.
  double PeakBytes() const;

 private:
  explicit ServerProcess(std::vector<std::string> command);

  pid_t pid_ = -1;
  FILE* log_ = nullptr;
  clockid_t clock_ = 0;
  std::string address_;
};

}  // namespace curvd::bench
