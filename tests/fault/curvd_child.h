// A curvd process of this program's own, and what the system tells about it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace curvd {

// What a process holds.
struct ProcessUsage {
  uint64_t resident_bytes = 0;
  uint64_t peak_bytes = 0;  // of resident memory, since the process began
  int threads = 0;
  int descriptors = 0;
};

// Not thread-safe, save for the const methods.
class CurvdChild {
 public:
  // Starts `binary` on free ports with `flags`, its log switched off. Ends this program if it cannot.
  CurvdChild(const std::string& binary, std::vector<std::string> flags);
  // Drains it; ends this program if that does not end with status 0.
  ~CurvdChild();
  CurvdChild(const CurvdChild&) = delete;
  CurvdChild& operator=(const CurvdChild&) = delete;

  const std::string& address() const { return address_; }
  // The value of `series`, written as in a scrape; 0 if there is none.
  double Metric(const std::string& series) const;
  bool IsIdle() const;
  // Ends this program if it takes longer than a minute.
  void WaitUntilIdle() const;

  ProcessUsage Usage() const;
  // CPU time that its threads have used, in nanoseconds.
  uint64_t CpuNanoseconds() const;
  bool IsAlive() const;

 private:
  pid_t pid_ = -1;
  std::string address_;
  std::string metrics_address_;
};

// Prints "PROGRAM: message" and ends this program with status 1: a finding, or nothing that can be tried.
[[noreturn]] void Fail(const std::string& message);

}  // namespace curvd
