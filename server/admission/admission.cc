#include "server/admission/admission.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "core/cloud/point_set.h"
#include "core/estimators/curvature_field.h"
#include "core/job/job_memory.h"
#include "core/normals/normals.h"
#include "server/call/chunk/directions.h"
#include "server/call/chunk/viewpoints.h"
#include "server/call/result_encoder.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

constexpr uint64_t kSmallLaneShare = 8;
constexpr char kSmallLaneName[] = "1/8 of memory_limit";
constexpr char kLargeLaneName[] = "7/8 of memory_limit";
// A small call may take this part of its lane at most, so that several fit.
constexpr uint64_t kSmallCallShare = 4;
// What gRPC and the call's own objects hold beside the arrays.
constexpr uint64_t kFixedCallBytes = 64 << 10;
// A chunk exists as slices of the wire, as points that were appended, and parsed where protobuf has to read it.
constexpr uint64_t kChunkCopies = 3;
// A result message may still be on its way while the next one is packed.
constexpr uint64_t kResultCopies = 2;

uint64_t ResultMessageBytes(uint64_t points, const QuantitySet& quantities) {
  return kResultCopies * ResultBytesPerPoint(quantities) * std::min<uint64_t>(points, ResultChunkPoints(quantities));
}

// Of the core's arrays.
uint64_t JobBytes(uint64_t points, const CallOptions& options, int thread_count) {
  if (!options.quantities.HasCurvature()) {
    return points * NormalsJobBytesPerPoint(options.normals) +
           NormalsJobScratchBytes(options.normals, points, thread_count);
  }
  return points * EstimationBytesPerPoint(options.estimator, options.normals) +
         EstimationScratchBytes(options.estimator, points, thread_count, options.normals);
}

uint64_t PartBytes(uint64_t points, const CallOptions& options) {
  return points * PointSet::BytesPerPoint(options.part.has_ids, options.part.has_roles);
}

// Of what comes with the points beside positions and normals.
uint64_t VectorBytes(uint64_t points, const CallOptions& options) {
  const bool is_growing = options.point_count == 0;
  uint64_t bytes = 0;
  if (options.has_viewpoints()) bytes += Viewpoints::kBytesPerPoint * (is_growing ? Viewpoints::kGrowing : 1);
  if (options.has_directions()) bytes += Directions::kBytesPerPoint * (is_growing ? Directions::kGrowing : 1);
  return points * bytes;
}

}  // namespace

Admission::Admission(uint64_t memory_bytes, uint64_t max_chunk_bytes, size_t max_waiting, int thread_count)
    : max_chunk_bytes_(max_chunk_bytes),
      thread_count_(thread_count),
      small_(memory_bytes / kSmallLaneShare, max_waiting, MemoryBudget::Clock::now, kSmallLaneName),
      large_(memory_bytes - memory_bytes / kSmallLaneShare, max_waiting, MemoryBudget::Clock::now, kLargeLaneName) {}

uint64_t Admission::CallBytes(uint64_t points, const CallOptions& options, bool more_may_follow) const {
  const uint64_t chunk =
      more_may_follow ? max_chunk_bytes_ : std::min<uint64_t>(max_chunk_bytes_, points * options.point_bytes());
  return kFixedCallBytes + JobBytes(points, options, thread_count_) + VectorBytes(points, options) +
         PartBytes(points, options) + kChunkCopies * chunk + ResultMessageBytes(points, options.quantities);
}

uint64_t Admission::SendingBytes(uint64_t points, const CallOptions& options) const {
  const QuantitySet& quantities = options.quantities;
  const uint64_t point_bytes =
      (quantities.HasCurvature() ? options.estimator.scale_count() * sizeof(PointCurvature) : 0) +
      (quantities.HasNormals() ? sizeof(PointNormal) : 0) + (quantities.HasChoice() ? sizeof(PointChoice) : 0);
  return kFixedCallBytes + points * point_bytes + (options.has_directions() ? VectorBytes(points, options) : 0) +
         ResultMessageBytes(points, quantities);
}

absl::StatusOr<std::unique_ptr<MemoryBudget::Reservation>> Admission::Enter(const CallOptions& options,
                                                                            uint64_t caller) {
  const uint64_t point_count = options.point_count;
  const uint64_t bytes = CallBytes(point_count, options, point_count == 0);
  if (bytes > large_.limit()) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     {kReasonMemoryLimit,
                      "header.point_count",
                      absl::StrCat(point_count, point_count == 0 ? " (unknown)" : "", ", which takes ", bytes,
                                   point_count == 0 ? " bytes of memory and more" : " bytes of memory"),
                      absl::StrCat("so small that it takes at most ", large_.limit(), " bytes (", kLargeLaneName, ")"),
                      {}});
  }
  const bool is_small = point_count != 0 && bytes <= small_.limit() / kSmallCallShare;
  return std::make_unique<MemoryBudget::Reservation>(is_small ? small_ : large_, caller);
}

}  // namespace curvd
