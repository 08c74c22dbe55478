// The program curvd as an operator runs it.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace curvd {

// A curvd process whose output is read here. Killed on destruction. Not thread-safe.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments,
                   const std::vector<std::pair<std::string, std::string>>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int number) const;
  // The next line of output that contains `text`; fails the test if there is none.
  std::string WaitForLine(const std::string& text);
  // All that is left to read.
  std::string ReadAll();
  // The exit status, or minus the number of the signal that ended it.
  int WaitForExit();

 private:
  pid_t pid_ = -1;
  FILE* output_ = nullptr;
  bool waited_ = false;
};

// The string that stands behind `key` in a line of JSON; "" if there is none.
std::string ValueIn(const std::string& line, const std::string& key);

}  // namespace curvd
