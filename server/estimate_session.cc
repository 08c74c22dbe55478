#include "server/estimate_session.h"

#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "server/error_detail.h"
#include "server/reasons.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

absl::Status Invalid(const char* reason, std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {reason, std::move(field), std::move(value), std::move(limit), {}});
}

absl::Status OverLimit(const char* reason, std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   {reason, std::move(field), std::move(value), std::move(limit), {}});
}

// Core's errors about points already name point and value.
absl::Status ExplainAppend(absl::Status status) {
  if (absl::IsInvalidArgument(status)) return WithDetail(std::move(status), {kReasonInvalidPoint, "chunk", "", "", {}});
  if (absl::IsResourceExhausted(status)) {
    return WithDetail(std::move(status), {kReasonOutOfMemory, "memory", "", "", absl::Seconds(1)});
  }
  return status;
}

}  // namespace

absl::Status EstimateSession::Keep(absl::Status status) {
  failure_ = status;
  return status;
}

absl::Status EstimateSession::Receive(const v1::EstimateCurvatureRequest& message) {
  if (!failure_.ok()) return failure_;
  switch (message.message_case()) {
    case v1::EstimateCurvatureRequest::kHeader:
      return Keep(ReceiveHeader(message.header()));
    case v1::EstimateCurvatureRequest::kChunk:
      return Keep(ReceiveChunk(message.chunk()));
    case v1::EstimateCurvatureRequest::MESSAGE_NOT_SET:
      break;
  }
  return Keep(Invalid(kReasonMessageEmpty, "message", "empty", "a header or a chunk"));
}

absl::Status EstimateSession::ReceiveMalformed(uint64_t bytes) {
  if (!failure_.ok()) return failure_;
  return Keep(Invalid(kReasonMessageMalformed, "message", absl::StrCat(bytes, " bytes that cannot be parsed"),
                      "a curvature.v1.EstimateCurvatureRequest in protobuf's wire format"));
}

absl::Status EstimateSession::ReceiveHeader(const v1::CloudHeader& header) {
  if (has_header()) {
    return Invalid(kReasonHeaderRepeated, "message", "a second header", "a chunk: only the first message is a header");
  }
  absl::StatusOr<CallOptions> options = ResolveHeader(header, limits_);
  if (!options.ok()) return options.status();
  options_ = *std::move(options);
  cloud_ = Cloud(options_->scalar_type, options_->invalid_point_policy);
  return absl::OkStatus();
}

absl::Status EstimateSession::ReceiveChunk(const v1::PointChunk& chunk) {
  if (!has_header()) return Invalid(kReasonHeaderMissing, "first message", "a chunk", "a header");
  if (chunk.first_index() != points_received_) {
    return Invalid(kReasonChunkOutOfOrder, "chunk.first_index", absl::StrCat(chunk.first_index()),
                   absl::StrCat(points_received_, ", the number of points sent before"));
  }
  const absl::StatusOr<uint64_t> count = CheckLengths(chunk);
  if (!count.ok()) return count.status();
  if (absl::Status status = CheckTotal(points_received_ + *count); !status.ok()) return status;
  if (*count == 0) return absl::OkStatus();
  absl::Status status = cloud_.Append(chunk.positions(), chunk.normals());
  if (!status.ok()) return ExplainAppend(std::move(status));
  points_received_ += *count;
  return status;
}

absl::StatusOr<uint64_t> EstimateSession::CheckLengths(const v1::PointChunk& chunk) const {
  const uint64_t bytes = chunk.positions().size() + chunk.normals().size();
  if (bytes > limits_.max_chunk_bytes) {
    return OverLimit(kReasonChunkTooLarge, "chunk.positions and chunk.normals together", absl::StrCat(bytes, " bytes"),
                     absl::StrCat("at most ", limits_.max_chunk_bytes, " bytes (max_chunk_bytes)"));
  }
  const bool is_float = options_->scalar_type == ScalarType::kFloat32;
  const uint64_t point_bytes = 3 * ScalarBytes(options_->scalar_type);
  if (chunk.positions().size() % point_bytes != 0) {
    return Invalid(
        kReasonChunkLength, "chunk.positions", absl::StrCat(chunk.positions().size(), " bytes"),
        absl::StrCat("a multiple of ", point_bytes, " bytes (3 ", is_float ? "float32" : "float64", " a point)"));
  }
  if (chunk.normals().size() != chunk.positions().size()) {
    return Invalid(kReasonChunkLength, "chunk.normals", absl::StrCat(chunk.normals().size(), " bytes"),
                   absl::StrCat(chunk.positions().size(), " bytes, as chunk.positions: every point needs a normal"));
  }
  return chunk.positions().size() / point_bytes;
}

absl::Status EstimateSession::CheckTotal(uint64_t total) const {
  if (options_->point_count != 0 && total > options_->point_count) {
    return Invalid(kReasonPointCountMismatch, "number of points sent", absl::StrCat(total, " with this chunk"),
                   absl::StrCat(options_->point_count, " (header.point_count)"));
  }
  if (total > limits_.max_points) {
    return OverLimit(kReasonTooManyPoints, "number of points sent", absl::StrCat(total, " with this chunk"),
                     absl::StrCat("at most ", limits_.max_points, " (max_points)"));
  }
  return absl::OkStatus();
}

absl::Status EstimateSession::HalfClose() {
  if (!failure_.ok()) return failure_;
  if (!has_header()) return Keep(Invalid(kReasonHeaderMissing, "stream", "without a message", "a header, then chunks"));
  if (options_->point_count != 0 && points_received_ != options_->point_count) {
    return Keep(Invalid(kReasonPointCountMismatch, "number of points sent",
                        absl::StrCat(points_received_, " at the half-close"),
                        absl::StrCat(options_->point_count, " (header.point_count)")));
  }
  return Keep(ExplainAppend(cloud_.Finish()));
}

}  // namespace curvd
