#include "server/call/request_session.h"

#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/out_of_memory.h"
#include "core/base/page_pool.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "server/call/chunk/append_chunk.h"
#include "server/call/job_errors.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
namespace wire = curvature::wire;

constexpr wire::BulkLayout kPointChunk({v1::PointChunk::kFirstIndexFieldNumber, v1::PointChunk::kIsLastFieldNumber},
                                       {v1::PointChunk::kPositionsFieldNumber, v1::PointChunk::kNormalsFieldNumber,
                                        v1::PointChunk::kViewpointsFieldNumber,
                                        v1::PointChunk::kCurvatureDirectionsFieldNumber,
                                        v1::PointChunk::kIdsFieldNumber, v1::PointChunk::kRolesFieldNumber});

absl::Status Invalid(const char* reason, std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {reason, std::move(field), std::move(value), std::move(limit), {}});
}

absl::Status OverLimit(const char* reason, std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   {reason, std::move(field), std::move(value), std::move(limit), {}});
}

}  // namespace

absl::Status RequestSession::Keep(absl::Status status) {
  failure_ = status;
  return status;
}

absl::Status RequestSession::Receive(grpc::ByteBuffer& message) {
  if (!failure_.ok()) return failure_;
  // How long the arrays are is for the caller to decide.
  absl::Status status = CatchBadAlloc([&] { return ReceiveMessage(message); });
  return Keep(KindOf(status) == ErrorKind::kOutOfMemory ? ExplainOutOfMemory(std::move(status)) : std::move(status));
}

absl::Status RequestSession::ReceiveMessage(grpc::ByteBuffer& message) {
  wire::BulkMessage chunk;
  if (wire::ReadBulkMessage(message, v1::EstimateCurvatureRequest::kChunkFieldNumber, kPointChunk, chunk)) {
    return ReceiveChunk(
        {chunk.numbers[v1::PointChunk::kFirstIndexFieldNumber], chunk.numbers[v1::PointChunk::kIsLastFieldNumber] != 0,
         chunk.arrays[v1::PointChunk::kPositionsFieldNumber], chunk.arrays[v1::PointChunk::kNormalsFieldNumber],
         chunk.arrays[v1::PointChunk::kViewpointsFieldNumber],
         chunk.arrays[v1::PointChunk::kCurvatureDirectionsFieldNumber], chunk.arrays[v1::PointChunk::kIdsFieldNumber],
         chunk.arrays[v1::PointChunk::kRolesFieldNumber]});
  }
  const size_t bytes = message.Length();
  v1::EstimateCurvatureRequest request;
  if (grpc::SerializationTraits<v1::EstimateCurvatureRequest>::Deserialize(&message, &request).ok()) {
    return ReceiveRequest(request);
  }
  return Invalid(kReasonMessageMalformed, "message", absl::StrCat(bytes, " bytes that cannot be parsed"),
                 "a curvature.v1.EstimateCurvatureRequest in protobuf's wire format");
}

absl::Status RequestSession::ReceiveRequest(const v1::EstimateCurvatureRequest& request) {
  switch (request.message_case()) {
    case v1::EstimateCurvatureRequest::kHeader:
      return ReceiveHeader(request.header());
    case v1::EstimateCurvatureRequest::kChunk:
      return ReceiveChunk({request.chunk().first_index(),
                           request.chunk().is_last(),
                           {request.chunk().positions()},
                           {request.chunk().normals()},
                           {request.chunk().viewpoints()},
                           {request.chunk().curvature_directions()},
                           {request.chunk().ids()},
                           {request.chunk().roles()}});
    case v1::EstimateCurvatureRequest::MESSAGE_NOT_SET:
      break;
  }
  return Invalid(kReasonMessageEmpty, "message", "empty", "a header or a chunk");
}

absl::Status RequestSession::ReceiveHeader(const v1::CloudHeader& header) {
  if (has_header()) {
    return Invalid(kReasonHeaderRepeated, "message", "a second header", "a chunk: only the first message is a header");
  }
  absl::StatusOr<CallOptions> options = ResolveHeader(header, limits_);
  if (!options.ok()) return options.status();
  options_ = *std::move(options);
  cloud_ = Cloud(options_->scalar_type, options_->invalid_point_policy,
                 options_->has_normals() ? NormalsInput::kGiven : NormalsInput::kAbsent);
  cloud_.Expect(options_->point_count);
  if (options_->part.lattice.has_value()) cloud_.PlaceOn(*options_->part.lattice);
  viewpoints_.Expect(options_->point_count);
  directions_.Expect(options_->point_count);
  return absl::OkStatus();
}

absl::Status RequestSession::CheckOrder(const Chunk& chunk) const {
  if (!has_header()) return Invalid(kReasonHeaderMissing, "first message", "a chunk", "a header");
  if (has_last_chunk_) {
    return Invalid(kReasonChunkOutOfOrder, "message", "a chunk after the one with is_last",
                   "the half-close: no chunk follows the last");
  }
  if (chunk.first_index != points_received_) {
    return Invalid(kReasonChunkOutOfOrder, "chunk.first_index", absl::StrCat(chunk.first_index),
                   absl::StrCat(points_received_, ", the number of points sent before"));
  }
  return absl::OkStatus();
}

absl::Status RequestSession::ReceiveChunk(const Chunk& chunk) {
  if (absl::Status status = CheckOrder(chunk); !status.ok()) return status;
  const absl::StatusOr<uint64_t> count = CheckLengths(chunk);
  if (!count.ok()) return count.status();
  if (absl::Status status = CheckTotal(points_received_ + *count); !status.ok()) return status;
  if (absl::Status status = AppendPoints(chunk, *count); !status.ok()) return ExplainCloudError(std::move(status));
  points_received_ += *count;
  has_last_chunk_ = chunk.is_last;
  // gRPC takes memory for the next message, and ends the process when it gets none.
  if (!ProcessPages().HasRoomFor(limits_.max_chunk_bytes)) return OutOfMemoryError();
  return absl::OkStatus();
}

absl::Status RequestSession::AppendPoints(const Chunk& chunk, uint64_t count) {
  const ScalarType type = options_->scalar_type;
  if (options_->part.has_ids || options_->part.has_roles) {
    if (absl::Status status = DescribePieces(chunk.ids, chunk.roles, count, cloud_); !status.ok()) return status;
  }
  if (options_->has_directions()) {
    if (absl::Status status = directions_.Append(chunk.directions, type); !status.ok()) return status;
  }
  if (!options_->has_viewpoints()) return AppendPieces(chunk.positions, chunk.normals, type, cloud_);
  if (absl::Status status = viewpoints_.Append(chunk.viewpoints, type); !status.ok()) return status;
  return AppendSeenPieces(chunk.positions, chunk.normals, type, viewpoints_, cloud_);
}

absl::StatusOr<uint64_t> RequestSession::CheckLengths(const Chunk& chunk) const {
  const uint64_t positions = wire::SizeOf(chunk.positions), normals = wire::SizeOf(chunk.normals);
  const uint64_t viewpoints = wire::SizeOf(chunk.viewpoints), directions = wire::SizeOf(chunk.directions);
  const uint64_t bytes =
      positions + normals + viewpoints + directions + wire::SizeOf(chunk.ids) + wire::SizeOf(chunk.roles);
  if (bytes > limits_.max_chunk_bytes) {
    return OverLimit(kReasonChunkTooLarge, "chunk.positions and the other arrays together",
                     absl::StrCat(bytes, " bytes"),
                     absl::StrCat("at most ", limits_.max_chunk_bytes, " bytes (max_chunk_bytes)"));
  }
  if (positions % point_bytes() != 0) {
    const bool is_float = options_->scalar_type == ScalarType::kFloat32;
    return Invalid(
        kReasonChunkLength, "chunk.positions", absl::StrCat(positions, " bytes"),
        absl::StrCat("a multiple of ", point_bytes(), " bytes (3 ", is_float ? "float32" : "float64", " a point)"));
  }
  if (absl::Status status = CheckNormals(normals, positions); !status.ok()) return status;
  if (absl::Status status = CheckViewpoints(viewpoints, positions); !status.ok()) return status;
  if (absl::Status status = CheckDirections(directions, positions); !status.ok()) return status;
  const uint64_t count = positions / point_bytes();
  if (absl::Status status = CheckPart(chunk, count); !status.ok()) return status;
  return count;
}

absl::Status RequestSession::CheckPart(const Chunk& chunk, uint64_t count) const {
  const auto check = [count](const char* field, const char* flag, bool is_announced, uint64_t bytes,
                             uint64_t point_bytes) {
    if (bytes == (is_announced ? count * point_bytes : 0)) return absl::OkStatus();
    return Invalid(kReasonChunkLength, field, absl::StrCat(bytes, " bytes"),
                   is_announced ? absl::StrCat(count * point_bytes, " bytes, ", point_bytes,
                                               " for each point of chunk.positions (", flag, " is true)")
                                : absl::StrCat("absent unless ", flag, " is true"));
  };
  const CloudPart& part = options_->part;
  absl::Status status =
      check("chunk.ids", "header.part.has_ids", part.has_ids, wire::SizeOf(chunk.ids), sizeof(uint64_t));
  if (!status.ok()) return status;
  return check("chunk.roles", "header.part.has_roles", part.has_roles, wire::SizeOf(chunk.roles), 1);
}

absl::Status RequestSession::CheckNormals(size_t normals, size_t positions) const {
  if (normals == (options_->has_normals() ? positions : 0)) return absl::OkStatus();
  const std::string value = absl::StrCat(normals, " bytes");
  if (!options_->has_normals()) {
    return Invalid(kReasonChunkLength, "chunk.normals", value,
                   "absent: header.normals.source asks for estimated ones; to use these, set it to given or orient");
  }
  const char* remedy = normals == 0 ? "; without normals, set header.normals.source to estimate" : "";
  return Invalid(kReasonChunkLength, "chunk.normals", value,
                 absl::StrCat(positions, " bytes, as chunk.positions: every point needs a normal", remedy));
}

absl::Status RequestSession::CheckViewpoints(size_t viewpoints, size_t positions) const {
  if (viewpoints == (options_->has_viewpoints() ? positions : 0)) return absl::OkStatus();
  const std::string value = absl::StrCat(viewpoints, " bytes");
  if (!options_->has_viewpoints()) {
    return Invalid(kReasonChunkLength, "chunk.viewpoints", value,
                   "absent unless header.normals.orientation is 4 (point viewpoints)");
  }
  return Invalid(kReasonChunkLength, "chunk.viewpoints", value,
                 absl::StrCat(positions,
                              " bytes, as chunk.positions: every point needs a viewpoint "
                              "(header.normals.orientation is 4)"));
}

absl::Status RequestSession::CheckDirections(size_t directions, size_t positions) const {
  if (directions == (options_->has_directions() ? positions : 0)) return absl::OkStatus();
  const std::string value = absl::StrCat(directions, " bytes");
  if (!options_->has_directions()) {
    return Invalid(kReasonChunkLength, "chunk.curvature_directions", value,
                   "absent unless header.quantities has 13 (normal curvature) and header.curvature_direction is unset");
  }
  return Invalid(
      kReasonChunkLength, "chunk.curvature_directions", value,
      absl::StrCat(positions,
                   " bytes, as chunk.positions: every point needs a direction "
                   "(header.quantities has 13, normal curvature), unless header.curvature_direction is set"));
}

absl::Status RequestSession::CheckTotal(uint64_t total) const {
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

absl::Status RequestSession::HalfClose() {
  if (!failure_.ok()) return failure_;
  if (!has_header()) return Keep(Invalid(kReasonHeaderMissing, "stream", "without a message", "a header, then chunks"));
  if (options_->point_count != 0 && points_received_ != options_->point_count) {
    return Keep(Invalid(kReasonPointCountMismatch, "number of points sent",
                        absl::StrCat(points_received_, " at the half-close"),
                        absl::StrCat(options_->point_count, " (header.point_count)")));
  }
  if (options_->marks_last_chunk && !has_last_chunk_) {
    return Keep(Invalid(kReasonCloudIncomplete, "stream",
                        absl::StrCat(points_received_, " points without a last chunk at the half-close"),
                        "whole: header.marks_last_chunk promised a chunk with is_last"));
  }
  absl::Status status = CatchBadAlloc([&] { return cloud_.Finish(); });
  return Keep(status.ok() ? status : ExplainCloudError(std::move(status)));
}

}  // namespace curvd
