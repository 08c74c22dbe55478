// Runs the real program.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/client/temp_dir.h"

namespace curv {

struct CurvRun {
  int exit_code;  // 128 + signal if a signal ended it
  std::string out;
  std::string err;
};

// A run that goes on. REQUIRES: Wait is called.
class RunningCurv {
 public:
  // As RunCurv.
  explicit RunningCurv(const std::vector<std::string>& arguments, const std::string& input = "",
                       const std::string& output = "");

  // Returns once the program watches for signals or has ended, or after a minute.
  void AwaitInterruptWatch() const;
  void Signal(int signal) const;
  // Returns how it ended. What has not after `most_seconds` is killed.
  CurvRun Wait(int most_seconds = 600);

 private:
  TempDir dir_;
  bool has_out_;
  pid_t child_ = -1;
};

// `input` is the file that it reads as standard input; none if empty. `output` is where its standard output goes
// instead of CurvRun::out; nowhere else if empty.
CurvRun RunCurv(const std::vector<std::string>& arguments, const std::string& input = "",
                const std::string& output = "");

}  // namespace curv
