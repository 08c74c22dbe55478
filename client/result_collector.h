// The client's side of the protocol: takes the server's messages in order, and lets nothing incomplete pass.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/curvature_client.h"
#include "curvature/v1/curvature.pb.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/bulk_message.h"
#include "proto/result_columns.h"

namespace curv {

// Not thread-safe.
class ResultCollector {
 public:
  // For a cloud of `points` points, for which the request asked with those options.
  explicit ResultCollector(uint64_t points, const EstimateOptions& options = {})
      : points_(points),
        results_(points),
        quantities_(options.quantities),
        normals_(options.normals.source),
        counts_(options.neighbor_counts),
        needs_scale_(options.automatic_scale.has_value() && counts_.empty()),
        needs_part_(options.lattice.has_value()) {}
  // For that cloud: results come for its queries.
  ResultCollector(const CloudView& cloud, const EstimateOptions& options) : ResultCollector(cloud.size(), options) {
    results_ = cloud.query_count();
    needs_part_ = needs_part_ || !cloud.ids().empty() || !cloud.roles().empty();
  }

  // Takes the next message; what remains in `message` is undefined. INTERNAL, naming what was found and expected, if
  // the protocol does not allow it here: bytes that are no EstimateCurvatureResponse, a result before Accepted or with
  // a gap, an array of the wrong length or one that Accepted does not tell of, a quantity that is left out, anything
  // after the Summary, a Summary that contradicts the results. UNIMPLEMENTED if the server takes normals as given that
  // it was to make or orient, chooses no scale where it was to, takes one neighbor count where it was to take several,
  // or knows no parts of clouds. Nothing may follow an error.
  absl::Status Take(grpc::ByteBuffer& message);

  // Ends the stream. INTERNAL if it is not complete: no Summary.
  absl::Status Finish() const;

  bool accepted() const { return accepted_; }
  // In force once accepted.
  const curvature::v1::ServerLimits& limits() const { return limits_; }
  const curvature::v1::Progress& progress() const { return progress_; }
  // Results of points; of several scales, in the mean.
  uint64_t points_received() const {
    return counts_.empty() ? received_ : (scales_.size() * results_ + received_) / counts_.size();
  }
  // What was collected. REQUIRES: Finish() is OK.
  CurvatureResult Release();

 private:
  absl::Status TakeResponse(const curvature::v1::EstimateCurvatureResponse& response);
  absl::Status TakeAccepted(const curvature::v1::Accepted& accepted);
  absl::Status TakeResult(const curvature::wire::BulkMessage& chunk);
  absl::Status TakeSummary(const curvature::v1::Summary& summary);
  // A column of results as far as it was received.
  struct Collected {
    const curvature::wire::ResultColumn* column;
    NamedColumn values;
  };
  const std::vector<uint8_t>& Statuses() const;
  // Begins the next scale if the one at hand is complete. An error if a chunk of that many neighbors is of another one.
  absl::Status CheckScale(uint64_t neighbor_count);
  // Counts the statuses of the scale at hand.
  void CountStatuses();
  // Takes the columns of the scale at hand out.
  CurvatureResult TakeColumns();

  uint64_t points_;   // sent
  uint64_t results_;  // that come back
  std::vector<std::string> quantities_;
  NormalSource normals_;
  std::vector<uint32_t> counts_;  // several neighbor counts; empty: there is one scale
  bool needs_scale_;
  bool needs_part_;
  uint64_t received_ = 0;
  bool accepted_ = false;
  bool summarized_ = false;
  curvature::v1::ServerLimits limits_;
  curvature::v1::Progress progress_;
  std::vector<Collected> columns_;       // those that Accepted tells of, at the scale at hand
  std::vector<CurvatureResult> scales_;  // complete ones, where there are several
  std::array<uint64_t, kStatusWords.size()> counted_{};
  EstimateSummary summary_;
};

}  // namespace curv
