#include "core/normals/normal_options.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/error.h"
#include "core/estimators/fits/jet_systems.h"

namespace curvd {
namespace {

bool IsFinite(const std::array<double, 3>& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

absl::Status Invalid(const std::string& message) { return MakeCoreError(ErrorKind::kInvalid, message); }

absl::Status ValidateScale(const NormalOptions& options) {
  const NormalMethod method = options.method.value_or(NormalMethod::kJet2);
  if (const auto* neighbors = std::get_if<NeighborCount>(&options.neighborhood)) {
    const uint32_t least = LeastNeighborCount(method);
    if (neighbors->count >= least && neighbors->count <= options.max_neighbor_count) return absl::OkStatus();
    return Invalid(absl::StrFormat("normals.neighbor_count is %u; for the method %s it must be from %u to %u",
                                   neighbors->count, NormalMethodName(method), least, options.max_neighbor_count));
  }
  if (const auto* ball = std::get_if<NeighborRadius>(&options.neighborhood)) {
    if (std::isfinite(ball->radius) && ball->radius > 0.0) return absl::OkStatus();
    return Invalid(absl::StrFormat("normals.radius is %g; it must be finite and greater than 0", ball->radius));
  }
  return absl::OkStatus();
}

absl::Status ValidateSides(const NormalOptions& options, size_t point_count) {
  if (const auto* one = std::get_if<SidesTowardViewpoint>(&options.sides)) {
    const auto& v = one->viewpoint;
    if (IsFinite(v)) return absl::OkStatus();
    return Invalid(absl::StrFormat("normals.viewpoint is %g, %g, %g; it must be finite", v[0], v[1], v[2]));
  }
  if (const auto* each = std::get_if<SidesTowardViewpoints>(&options.sides)) {
    if (each->viewpoints.size() == point_count) return absl::OkStatus();
    return Invalid(absl::StrFormat("normals.viewpoints holds %u viewpoints for %u points; it must hold one for each",
                                   each->viewpoints.size(), point_count));
  }
  if (const auto* along = std::get_if<SidesAlongDirection>(&options.sides)) {
    const auto& d = along->direction;
    if (IsFinite(d) && (d[0] != 0.0 || d[1] != 0.0 || d[2] != 0.0)) return absl::OkStatus();
    return Invalid(
        absl::StrFormat("normals.direction is %g, %g, %g; it must be finite and not zero", d[0], d[1], d[2]));
  }
  return absl::OkStatus();
}

}  // namespace

std::string_view NormalMethodName(NormalMethod method) {
  constexpr std::string_view kNames[] = {"pca", "jet-1", "jet-2", "jet-4"};
  return kNames[static_cast<size_t>(method)];
}

int JetDegree(NormalMethod method) {
  constexpr int kDegrees[] = {0, 1, 2, 4};
  return kDegrees[static_cast<size_t>(method)];
}

uint32_t LeastNeighborCount(NormalMethod method) {
  return std::max(kMinNeighborCount, static_cast<uint32_t>(JetSize(JetDegree(method))));
}

absl::Status NormalOptions::Validate(size_t point_count) const {
  if (source == NormalSource::kEstimate) {
    if (absl::Status status = ValidateScale(*this); !status.ok()) return status;
  }
  return source == NormalSource::kGiven ? absl::OkStatus() : ValidateSides(*this, point_count);
}

}  // namespace curvd
