#include "core/normals/normal_options.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/estimators/fits/jet_systems.h"

namespace curvd {
namespace {

bool IsFinite(const std::array<double, 3>& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

absl::Status ValidateScale(const NormalOptions& options) {
  const NormalMethod method = options.method.value_or(NormalMethod::kJet2);
  if (const auto* neighbors = std::get_if<NeighborCount>(&options.neighborhood)) {
    const uint32_t least = LeastNeighborCount(method);
    if (neighbors->count >= least && neighbors->count <= options.max_neighbor_count) return absl::OkStatus();
    return InvalidValue("normals.neighbor_count", absl::StrCat(neighbors->count),
                        absl::StrCat("from ", least, " to ", options.max_neighbor_count, " for the method ",
                                     std::string(NormalMethodName(method))));
  }
  if (const auto* ball = std::get_if<NeighborRadius>(&options.neighborhood)) {
    if (std::isfinite(ball->radius) && ball->radius > 0.0) return absl::OkStatus();
    return InvalidValue("normals.radius", NumberText(ball->radius), "finite and greater than 0");
  }
  return absl::OkStatus();
}

absl::Status ValidateSides(const NormalOptions& options, size_t point_count) {
  if (const auto* one = std::get_if<SidesTowardViewpoint>(&options.sides)) {
    if (IsFinite(one->viewpoint)) return absl::OkStatus();
    return InvalidValue("normals.viewpoint", VectorText(one->viewpoint), "finite");
  }
  if (const auto* each = std::get_if<SidesTowardViewpoints>(&options.sides)) {
    if (each->viewpoints.size() == point_count) return absl::OkStatus();
    return InvalidValue("normals.viewpoints", absl::StrCat("a list of ", each->viewpoints.size()),
                        absl::StrCat("a list of ", point_count, ", one for each point"));
  }
  if (const auto* along = std::get_if<SidesAlongDirection>(&options.sides)) {
    const auto& d = along->direction;
    if (IsFinite(d) && (d[0] != 0.0 || d[1] != 0.0 || d[2] != 0.0)) return absl::OkStatus();
    return InvalidValue("normals.direction", VectorText(d), "finite and not zero");
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
