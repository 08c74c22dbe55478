// Runs the real program.
#pragma once

#include <string>
#include <vector>

namespace curv {

struct CurvRun {
  int exit_code;  // 128 + signal if a signal ended it
  std::string out;
  std::string err;
};

// `input` is the file that it reads as standard input; none if empty. `output` is where its standard output goes
// instead of CurvRun::out; nowhere else if empty.
CurvRun RunCurv(const std::vector<std::string>& arguments, const std::string& input = "",
                const std::string& output = "");

}  // namespace curv
