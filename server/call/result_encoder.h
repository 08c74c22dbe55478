// Turns a part of a call's results into a message for the wire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/normal_curvature.h"
#include "core/estimators/point_choice.h"
#include "core/normals/normals.h"
#include "grpcpp/support/slice.h"
#include "server/call/chunk/directions.h"
#include "server/call/quantity_set.h"

namespace curvd {

// What the job of a call has found, as far as it was asked for.
struct CallResults {
  PageArray<PointCurvature> curvature;
  NormalField normals{};
  ChoiceField choices{};
  Directions directions{};  // of the points; none: `direction` is that of all
  Direction direction{};
  // At the other scales, from large to small; `curvature` is that of the largest.
  std::vector<PageArray<PointCurvature>> smaller{};

  size_t size() const { return curvature.size() > 0 ? curvature.size() : normals.size(); }
};

// Bytes of a point in a ResultChunk with those quantities.
size_t ResultBytesPerPoint(const QuantitySet& quantities);
// Points of one ResultChunk with those quantities: so many that a message stays below 1 MiB, far from the 4 MiB that
// gRPC clients take by default, and no more than kResultChunkPoints.
inline constexpr size_t kResultChunkPoints = 16'384;
size_t ResultChunkPoints(const QuantitySet& quantities);

// Returns the EstimateCurvatureResponse with the results of points [first, first + count), the arrays of `quantities`
// only, as protobuf would serialize it. They are those of `curvature`; with `smaller`, of that array instead, and with
// `neighbor_count`, the message says that they are of so many. The status is that of curvature, if there is any. It is
// laid out here so that the arrays are written once, into the memory that gRPC sends. Takes about 4 ns a point.
// REQUIRES: count > 0, first + count <= results.size(); `results` has what the quantities need.
//
// Returns an error of kind kOutOfMemory if the system has so little memory left that gRPC might not get what it needs
// to send the message: it ends the process then.
struct PackedScale {
  const PageArray<PointCurvature>* smaller = nullptr;
  uint32_t neighbor_count = 0;  // 0: the message does not say
};
absl::StatusOr<grpc::Slice> PackResults(const CallResults& results, size_t first, size_t count,
                                        const QuantitySet& quantities, const PackedScale& scale = {});

}  // namespace curvd
