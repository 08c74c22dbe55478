#include "server/call/wire_normals.h"

#include <array>
#include <cmath>
#include <string>
#include <variant>

#include "absl/strings/str_cat.h"
#include "core/base/number_text.h"
#include "server/call/invalid_option.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr std::array kMethods = {v1::NORMAL_METHOD_PCA, v1::NORMAL_METHOD_JET_1, v1::NORMAL_METHOD_JET_2,
                                 v1::NORMAL_METHOD_JET_4};  // by NormalMethod

std::array<double, 3> ToArray(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

std::string Text(const v1::Vector3& v) { return VectorText(ToArray(v)); }

bool IsFinite(const v1::Vector3& v) { return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z()); }

absl::Status ReadSource(v1::NormalSource source, NormalOptions& options) {
  switch (source) {
    case v1::NORMAL_SOURCE_UNSPECIFIED:
    case v1::NORMAL_SOURCE_GIVEN:
      options.source = NormalSource::kGiven;
      return absl::OkStatus();
    case v1::NORMAL_SOURCE_ORIENT:
      options.source = NormalSource::kOrient;
      return absl::OkStatus();
    case v1::NORMAL_SOURCE_ESTIMATE:
      options.source = NormalSource::kEstimate;
      return absl::OkStatus();
    default:
      return InvalidOption("header.normals.source", absl::StrCat(static_cast<int>(source)),
                           "1 (given), 2 (orient) or 3 (estimate)");
  }
}

// A caller who sets what has no effect means something else than what would be done.
absl::Status RefuseWithoutEffect(const v1::NormalOptions& proto, NormalSource source) {
  if (source != NormalSource::kEstimate) {
    constexpr char kLimit[] = "unset unless header.normals.source is 3 (estimate)";
    if (proto.method() != v1::NORMAL_METHOD_UNSPECIFIED) {
      return InvalidOption("header.normals.method", absl::StrCat(static_cast<int>(proto.method())), kLimit);
    }
    if (proto.has_neighbor_count()) {
      return InvalidOption("header.normals.neighbor_count", absl::StrCat(proto.neighbor_count()), kLimit);
    }
    if (proto.has_radius()) return InvalidOption("header.normals.radius", NumberText(proto.radius()), kLimit);
  }
  if (source == NormalSource::kGiven && proto.orientation() != v1::ORIENTATION_UNSPECIFIED) {
    return InvalidOption("header.normals.orientation", absl::StrCat(static_cast<int>(proto.orientation())),
                         "unset unless header.normals.source is 2 (orient) or 3 (estimate)");
  }
  if (proto.has_viewpoint() && proto.orientation() != v1::ORIENTATION_VIEWPOINT) {
    return InvalidOption("header.normals.viewpoint", Text(proto.viewpoint()),
                         "unset unless header.normals.orientation is 3 (viewpoint)");
  }
  if (proto.has_direction() && proto.orientation() != v1::ORIENTATION_DIRECTION) {
    return InvalidOption("header.normals.direction", Text(proto.direction()),
                         "unset unless header.normals.orientation is 5 (direction)");
  }
  return absl::OkStatus();
}

absl::Status ReadMethod(v1::NormalMethod proto, std::optional<NormalMethod>& method) {
  if (proto == v1::NORMAL_METHOD_UNSPECIFIED) return absl::OkStatus();
  for (size_t i = 0; i < kMethods.size(); ++i) {
    if (kMethods[i] == proto) method = static_cast<NormalMethod>(i);
  }
  if (method.has_value()) return absl::OkStatus();
  return InvalidOption("header.normals.method", absl::StrCat(static_cast<int>(proto)),
                       "1 (PCA), 2, 3 or 4 (jets of degree 1, 2 or 4)");
}

absl::Status ReadNeighborhood(const v1::NormalOptions& proto, const CallLimits& limits, NormalOptions& options) {
  if (proto.has_neighbor_count()) {
    const NormalMethod method = options.method.value_or(NormalMethod::kJet2);
    const uint32_t least = LeastNeighborCount(method);
    const std::string value = absl::StrCat(proto.neighbor_count());
    if (proto.neighbor_count() < least) {
      return InvalidOption("header.normals.neighbor_count", value,
                           absl::StrCat("at least ", least, " for the method ", std::string(NormalMethodName(method))));
    }
    if (proto.neighbor_count() > limits.max_neighbor_count) {
      return MakeError(absl::StatusCode::kResourceExhausted,
                       {kReasonNeighborhoodTooLarge,
                        "header.normals.neighbor_count",
                        value,
                        absl::StrCat("at most ", limits.max_neighbor_count, " (max_neighbor_count)"),
                        {}});
    }
    options.neighborhood = NeighborCount{proto.neighbor_count()};
  } else if (proto.has_radius()) {
    if (!std::isfinite(proto.radius()) || proto.radius() <= 0.0) {
      return InvalidOption("header.normals.radius", NumberText(proto.radius()), "finite and above 0");
    }
    options.neighborhood = NeighborRadius{proto.radius()};
  }
  return absl::OkStatus();
}

absl::Status ReadViewpoint(const v1::NormalOptions& proto, NormalOptions& options) {
  constexpr char kField[] = "header.normals.viewpoint";
  if (!proto.has_viewpoint()) return InvalidOption(kField, "unset", "set where header.normals.orientation is 3");
  if (!IsFinite(proto.viewpoint())) return InvalidOption(kField, Text(proto.viewpoint()), "finite");
  options.sides = SidesTowardViewpoint{ToArray(proto.viewpoint())};
  return absl::OkStatus();
}

absl::Status ReadDirection(const v1::NormalOptions& proto, NormalOptions& options) {
  constexpr char kField[] = "header.normals.direction";
  if (!proto.has_direction()) return InvalidOption(kField, "unset", "set where header.normals.orientation is 5");
  const v1::Vector3& v = proto.direction();
  if (!IsFinite(v) || (v.x() == 0.0 && v.y() == 0.0 && v.z() == 0.0)) {
    return InvalidOption(kField, Text(v), "finite and not zero");
  }
  options.sides = SidesAlongDirection{ToArray(v)};
  return absl::OkStatus();
}

absl::Status ReadOrientation(const v1::NormalOptions& proto, NormalOptions& options) {
  switch (proto.orientation()) {
    case v1::ORIENTATION_UNSPECIFIED:
    case v1::ORIENTATION_CONSISTENT:
      options.sides = ConsistentSides{};
      return absl::OkStatus();
    case v1::ORIENTATION_CLOSED:
      options.sides = ConsistentSides{.closed = true};
      return absl::OkStatus();
    case v1::ORIENTATION_VIEWPOINT:
      return ReadViewpoint(proto, options);
    case v1::ORIENTATION_POINT_VIEWPOINTS:
      options.sides = SidesTowardViewpoints{};
      return absl::OkStatus();
    case v1::ORIENTATION_DIRECTION:
      return ReadDirection(proto, options);
    default:
      return InvalidOption("header.normals.orientation", absl::StrCat(static_cast<int>(proto.orientation())),
                           "1 (consistent), 2 (closed), 3 (viewpoint), 4 (point viewpoints) or 5 (direction)");
  }
}

void Set(const std::array<double, 3>& from, v1::Vector3* to) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

void WriteOrientation(const NormalOptions& options, v1::NormalOptions& proto) {
  if (const auto* consistent = std::get_if<ConsistentSides>(&options.sides)) {
    proto.set_orientation(consistent->closed ? v1::ORIENTATION_CLOSED : v1::ORIENTATION_CONSISTENT);
  } else if (const auto* one = std::get_if<SidesTowardViewpoint>(&options.sides)) {
    proto.set_orientation(v1::ORIENTATION_VIEWPOINT);
    Set(one->viewpoint, proto.mutable_viewpoint());
  } else if (const auto* along = std::get_if<SidesAlongDirection>(&options.sides)) {
    proto.set_orientation(v1::ORIENTATION_DIRECTION);
    Set(along->direction, proto.mutable_direction());
  } else {
    proto.set_orientation(v1::ORIENTATION_POINT_VIEWPOINTS);
  }
}

}  // namespace

absl::Status ReadNormals(const v1::NormalOptions& proto, const CallLimits& limits, NormalOptions& options) {
  if (absl::Status status = ReadSource(proto.source(), options); !status.ok()) return status;
  if (absl::Status status = RefuseWithoutEffect(proto, options.source); !status.ok()) return status;
  if (absl::Status status = ReadMethod(proto.method(), options.method); !status.ok()) return status;
  if (absl::Status status = ReadNeighborhood(proto, limits, options); !status.ok()) return status;
  options.max_neighbor_count = limits.max_neighbor_count;
  return ReadOrientation(proto, options);
}

v1::NormalMethod WireNormalMethod(NormalMethod method) { return kMethods[static_cast<size_t>(method)]; }

void WriteNormals(const NormalOptions& options, v1::NormalOptions& proto) {
  constexpr std::array kSources = {v1::NORMAL_SOURCE_GIVEN, v1::NORMAL_SOURCE_ORIENT, v1::NORMAL_SOURCE_ESTIMATE};
  proto.set_source(kSources[static_cast<size_t>(options.source)]);
  if (options.source == NormalSource::kGiven) return;
  WriteOrientation(options, proto);
  if (options.source != NormalSource::kEstimate) return;
  if (const auto* count = std::get_if<NeighborCount>(&options.neighborhood)) proto.set_neighbor_count(count->count);
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) proto.set_radius(radius->radius);
  const bool is_automatic = std::holds_alternative<AutoNeighborhood>(options.neighborhood);
  if (!options.method.has_value() && is_automatic) return;
  proto.set_method(WireNormalMethod(options.method.value_or(NormalMethod::kJet2)));
}

void WriteReport(const NormalReport& report, v1::NormalsReport& proto) {
  if (report.method.has_value()) proto.set_method(WireNormalMethod(*report.method));
  proto.set_neighbor_count(report.neighbor_count);
  if (report.sigma.has_value()) proto.set_noise(*report.sigma);
  uint64_t points = 0;
  for (const uint64_t count : report.status_counts) points += count;
  proto.set_missing_count(points - report.status_counts[static_cast<size_t>(PointStatus::kOk)]);
  if (!report.method.has_value()) proto.set_turned_count(report.flipped_count);
  proto.set_piece_count(report.piece_count);
  proto.set_closed_piece_count(report.closed_piece_count);
  proto.set_closed_area_share(report.closed_area_share);
  proto.set_repaired_count(report.repaired_count);
  proto.set_inner_wall_count(report.inner_wall_count);
  if (report.certificate.has_value()) {
    proto.set_certificate(*report.certificate);
    proto.set_max_trusted_certificate(report.max_trusted_certificate);
  }
  proto.set_doubtful(report.is_doubtful());
  if (report.noisy_part.has_value()) {
    v1::NoisyNormals& noisy = *proto.mutable_noisy_part();
    noisy.set_method(WireNormalMethod(report.noisy_part->method));
    noisy.set_neighbor_count(report.noisy_part->neighbor_count);
    if (report.noisy_part->sigma.has_value()) noisy.set_noise(*report.noisy_part->sigma);
    noisy.set_share(report.noisy_part->share);
  }
}

}  // namespace curvd
