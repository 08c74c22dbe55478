#include "core/estimators/options.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/error.h"

namespace curvd {
namespace {

absl::Status ValidateCount(uint32_t count, uint32_t max_count) {
  if (count >= kMinNeighborCount && count <= max_count) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("neighbor_count is %u; it must be from %u to %u", count,
                                                            kMinNeighborCount, max_count));
}

absl::Status ValidateRadius(double radius) {
  if (std::isfinite(radius) && radius > 0.0) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid,
                       absl::StrFormat("radius is %g; it must be finite and greater than 0", radius));
}

}  // namespace

absl::Status EstimatorOptions::Validate() const {
  absl::Status status;
  if (const auto* count = std::get_if<NeighborCount>(&neighborhood)) {
    status = ValidateCount(count->count, max_neighbor_count);
  } else {
    status = ValidateRadius(std::get<NeighborRadius>(neighborhood).radius);
  }
  if (!status.ok()) return status;
  if (triangle_count < 1 || triangle_count > kMaxTriangleCount) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("triangle_count is %u; it must be from 1 to %u",
                                                              triangle_count, kMaxTriangleCount));
  }
  if (rotation_count < 1 || rotation_count > kMaxRotations) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("rotation_count is %u; it must be from 1 to %u",
                                                              rotation_count, kMaxRotations));
  }
  if (jet_degree < kMinJetDegree || jet_degree > kMaxJetDegree) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("jet_degree is %u; it must be from %u to %u", jet_degree,
                                                              kMinJetDegree, kMaxJetDegree));
  }
  if (!(average_normal_weight >= 0.0 && average_normal_weight <= 1.0)) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrFormat("average_normal_weight is %g; it must be from 0 to 1", average_normal_weight));
  }
  return absl::OkStatus();
}

}  // namespace curvd
