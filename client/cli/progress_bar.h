// Shows on one line of a terminal how far an estimate is.
#pragma once

#include <string>

#include "absl/time/time.h"
#include "client/curvature_client.h"

namespace curv {

// Not thread-safe.
class ProgressBar {
 public:
  // Silent unless stderr is a terminal. `title` stands before the progress.
  explicit ProgressBar(std::string title = "");
  // Wipes the line.
  ~ProgressBar();

  // Shows `progress`, at most ten times a second.
  void Show(const EstimateProgress& progress);

 private:
  std::string title_;
  bool visible_;
  bool drawn_ = false;
  absl::Time last_ = absl::InfinitePast();
  EstimateProgress::Phase phase_ = EstimateProgress::Phase::kConnecting;
  absl::Time phase_start_;
};

// Returns the line for `progress`, `seconds` after its phase began. It tells what was received and estimated, the rate
// of the phase, and the time that it still takes.
std::string ProgressLine(const EstimateProgress& progress, double seconds);

}  // namespace curv
