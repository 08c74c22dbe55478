// Shows on one line of a terminal how far work on many points is.
#pragma once

#include <cstdint>
#include <string>

#include "absl/time/time.h"

namespace curv {

// Not thread-safe.
class TilesBar {
 public:
  // Silent unless stderr is a terminal.
  TilesBar();
  // Wipes the line.
  ~TilesBar();

  // Shows `step`, and that `done` of `of` points are done; 0: nobody knows of how many. `what` stands behind it. Rate
  // and rest are those since the step began. At most ten times a second.
  void Show(const std::string& step, uint64_t done, uint64_t of, const std::string& what = "");

 private:
  bool visible_;
  bool drawn_ = false;
  absl::Time last_ = absl::InfinitePast();
  std::string step_;
  absl::Time step_start_;
  uint64_t step_first_ = 0;
};

}  // namespace curv
