// Shows on one line of a terminal how far an estimate is.
#pragma once

#include <optional>
#include <string>

#include "absl/time/time.h"
#include "client/curvature_client.h"

namespace curv {

// The part of the work on several files that one of them is.
struct BatchShare {
  std::string title;   // "3 of 12, scan.ply: "
  double begin = 0.0;  // which share of all of it is done before, from 0 to 1
  double end = 1.0;    // and with this file
};

// Not thread-safe.
class ProgressBar {
 public:
  // Silent unless stderr is a terminal. With `share`, one bar shows all of the work on several files.
  explicit ProgressBar(std::optional<BatchShare> share = std::nullopt);
  // Wipes the line.
  ~ProgressBar();

  // Shows `progress`, at most ten times a second.
  void Show(const EstimateProgress& progress);

 private:
  std::optional<BatchShare> share_;
  bool visible_;
  bool drawn_ = false;
  absl::Time last_ = absl::InfinitePast();
  EstimateProgress::Phase phase_ = EstimateProgress::Phase::kConnecting;
  absl::Time phase_start_;
};

// Returns the line for `progress`, `seconds` after its phase began. It tells what was received and estimated, the rate
// of the phase, and the time that it still takes.
std::string ProgressLine(const EstimateProgress& progress, double seconds);

// The line for one of several files: how far all of them are, as the share of their bytes, and this one.
std::string BatchLine(const BatchShare& share, const EstimateProgress& progress);

}  // namespace curv
