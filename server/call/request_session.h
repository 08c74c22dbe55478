// Takes the requests of an EstimateCurvature call; a state machine that knows no socket.
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/cloud/cloud.h"
#include "core/cloud/coarse_positions.h"
#include "curvature/v1/curvature.pb.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/bulk_message.h"
#include "server/call/chunk/directions.h"
#include "server/call/chunk/viewpoints.h"
#include "server/call/header_options.h"
#include "server/call/request_limits.h"

namespace curvd {

// One header, then chunks in order, then half-close. Every error carries an ErrorDetail and is final: later calls
// return it again. Not thread-safe.
class RequestSession {
 public:
  explicit RequestSession(const CallLimits& limits) : limits_(limits) {}

  // Takes the next message; what remains in `message` is undefined. A chunk's points are in the cloud when this
  // returns, copied from where gRPC received them. Errors:
  // - INVALID_ARGUMENT: bytes that are no EstimateCurvatureRequest, a wrong message, field, order or length, more
  //   points than header.point_count, or an invalid point that was not to be skipped.
  // - RESOURCE_EXHAUSTED: over max_points or max_chunk_bytes, or no memory.
  absl::Status Receive(grpc::ByteBuffer& message);

  // The client is done, or its stream was cut off, which gRPC does not tell apart. INVALID_ARGUMENT if there was no
  // header, not header.point_count points, or no last chunk where header.marks_last_chunk promised one.
  absl::Status HalfClose();

  bool has_header() const { return options_.has_value(); }
  // REQUIRES: has_header().
  const CallOptions& options() const { return *options_; }
  uint64_t points_received() const { return points_received_; }
  // Points whose normal was not of unit length. REQUIRES: TakeCloud was not called.
  uint64_t normals_rescaled() const { return cloud_.rescaled_count(); }
  // Tells of positions that floats round too coarsely (core/cloud/coarse_positions.h). REQUIRES: HalfClose returned OK,
  // TakeCloud was not called.
  std::optional<CoarsePositions> FindCoarsePositions() const { return curvd::FindCoarsePositions(cloud_); }

  // The cloud, complete. REQUIRES: HalfClose returned OK; called once.
  Cloud TakeCloud() { return std::move(cloud_); }
  // Where its points were seen from, if the header asked for that; empty else. REQUIRES: as above.
  Viewpoints TakeViewpoints() { return std::move(viewpoints_); }
  // The directions of its points, if each has its own; empty else. REQUIRES: as above.
  Directions TakeDirections() { return std::move(directions_); }

 private:
  absl::Status ReceiveMessage(grpc::ByteBuffer& message);
  absl::Status ReceiveHeader(const curvature::v1::CloudHeader& header);
  absl::Status ReceiveRequest(const curvature::v1::EstimateCurvatureRequest& request);
  struct Chunk {
    uint64_t first_index;
    bool is_last;
    const curvature::wire::Pieces& positions;
    const curvature::wire::Pieces& normals;
    const curvature::wire::Pieces& viewpoints;
    const curvature::wire::Pieces& directions;
    const curvature::wire::Pieces& ids;
    const curvature::wire::Pieces& roles;
  };
  absl::Status ReceiveChunk(const Chunk& chunk);
  // The chunk comes where a chunk may come.
  absl::Status CheckOrder(const Chunk& chunk) const;
  // The number of points in a chunk, if the lengths of its arrays are right.
  absl::StatusOr<uint64_t> CheckLengths(const Chunk& chunk) const;
  absl::Status CheckNormals(size_t normals, size_t positions) const;
  absl::Status CheckViewpoints(size_t viewpoints, size_t positions) const;
  absl::Status CheckDirections(size_t directions, size_t positions) const;
  absl::Status CheckPart(const Chunk& chunk, uint64_t count) const;
  absl::Status AppendPoints(const Chunk& chunk, uint64_t count);
  absl::Status CheckTotal(uint64_t total) const;
  absl::Status Keep(absl::Status status);
  // Bytes of one position. REQUIRES: has_header().
  size_t point_bytes() const { return 3 * ScalarBytes(options_->scalar_type); }

  const CallLimits limits_;
  absl::Status failure_;
  std::optional<CallOptions> options_;
  uint64_t points_received_ = 0;
  bool has_last_chunk_ = false;
  Cloud cloud_;
  Viewpoints viewpoints_;
  Directions directions_;
};

}  // namespace curvd
