// The client's side of the protocol: takes the server's messages in order, and lets nothing incomplete pass.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "client/curvature_client.h"
#include "curvature/v1/curvature.pb.h"

namespace curv {

// Not thread-safe.
class ResultCollector {
 public:
  // For a cloud of `points` points.
  explicit ResultCollector(uint64_t points) : points_(points) {}

  // Takes the next message. INTERNAL, naming what was found and expected, if the protocol does not allow it here: a
  // result before Accepted or with a gap, an array of the wrong length, anything after the Summary, a Summary that
  // contradicts the results.
  absl::Status Take(const curvature::v1::EstimateCurvatureResponse& response);

  // Ends the stream. INTERNAL if it is not complete: no Summary.
  absl::Status Finish() const;

  bool accepted() const { return accepted_; }
  // In force once accepted.
  const curvature::v1::ServerLimits& limits() const { return limits_; }
  const curvature::v1::Progress& progress() const { return progress_; }
  uint64_t points_received() const { return received_; }
  // What was collected. REQUIRES: Finish() is OK.
  CurvatureResult Release() { return std::move(result_); }

 private:
  absl::Status TakeAccepted(const curvature::v1::Accepted& accepted);
  absl::Status TakeResult(const curvature::v1::ResultChunk& chunk);
  absl::Status TakeSummary(const curvature::v1::Summary& summary);
  void MakeRoom();

  uint64_t points_;
  uint64_t received_ = 0;
  bool accepted_ = false;
  bool summarized_ = false;
  curvature::v1::ServerLimits limits_;
  curvature::v1::Progress progress_;
  CurvatureResult result_;
};

}  // namespace curv
