// A curvd of one's own, as an operator runs it: a process on a free loopback port.
#pragma once

#include <sys/types.h>
#include <time.h>

#include <cstdio>
#include <string>

namespace curvd::bench {

// Ends the program if the server does not start. Not thread-safe.
class CurvdProcess {
 public:
  explicit CurvdProcess(int threads);
  ~CurvdProcess();  // ends the server
  CurvdProcess(const CurvdProcess&) = delete;
  CurvdProcess& operator=(const CurvdProcess&) = delete;

  const std::string& address() const { return address_; }
  // CPU seconds of all its threads since it started.
  double CpuSeconds() const;
  // Most memory that it ever had resident, in bytes.
  double PeakBytes() const;

 private:
  pid_t pid_ = -1;
  FILE* log_ = nullptr;
  clockid_t clock_ = 0;
  std::string address_;
};

}  // namespace curvd::bench
