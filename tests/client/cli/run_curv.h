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

CurvRun RunCurv(const std::vector<std::string>& arguments);

}  // namespace curv
