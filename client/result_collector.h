// The client's side of the protocol: takes the server's messages in order, and lets nothing incomplete pass.
#pragma once

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
        needs_scale_(options.automatic_scale.has_value()),
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
  // it was to make or orient, chooses no scale where it was to, or knows no parts of clouds. Nothing may follow an error.
  absl::Status Take(grpc::ByteBuffer& message);

  // Ends the stream. INTERNAL if it is not complete: no Summary.
  absl::Status Finish() const;

  bool accepted() const { return accepted_; }
  // In force once accepted.
  const curvature::v1::ServerLimits& limits() const { return limits_; }
  const curvature::v1::Progress& progress() const { return progress_; }
  uint64_t points_received() const { return received_; }
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

  uint64_t points_;   // sent
  uint64_t results_;  // that come back
  std::vector<std::string> quantities_;
  NormalSource normals_;
  bool needs_scale_;
  bool needs_part_;
  uint64_t received_ = 0;
  bool accepted_ = false;
  bool summarized_ = false;
  curvature::v1::ServerLimits limits_;
  curvature::v1::Progress progress_;
  std::vector<Collected> columns_;  // those that Accepted tells of
  EstimateSummary summary_;
};

}  // namespace curv
