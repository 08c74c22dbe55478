#include "server/call/header_options.h"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/number_text.h"
#include "core/estimators/strategies.h"
#include "proto/result_columns.h"
#include "server/call/invalid_option.h"
#include "server/call/scale/choice_quantities.h"
#include "server/call/scale/wire_counts.h"
#include "server/call/scale/wire_scale.h"
#include "server/call/wire_normals.h"
#include "server/call/wire_options.h"
#include "server/call/wire_strategies.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr size_t kMaxTagBytes = 128;

absl::Status ResolveEstimator(v1::Estimator proto, std::string_view& estimator) {
  if (proto == v1::ESTIMATOR_UNSPECIFIED) return absl::OkStatus();
  if (proto == v1::ESTIMATOR_AUTO) {
    estimator = kAutomaticEstimator;
    return absl::OkStatus();
  }
  const Strategy* strategy = StrategyOf(proto);
  if (strategy == nullptr) {
    return InvalidOption("header.options.estimator", absl::StrCat(static_cast<int>(proto)),
                         "a value of curvature.v1.Estimator that this server knows");
  }
  estimator = strategy->name;
  return absl::OkStatus();
}

absl::Status ResolveNeighborhood(const v1::EstimatorOptions& proto, const CallLimits& limits,
                                 EstimatorOptions& options) {
  if (proto.neighbor_counts_size() > 0) {
    if (absl::Status status = ReadCounts(proto, limits, options); !status.ok()) return status;
  } else if (proto.has_neighbor_count()) {
    const std::string value = absl::StrCat(proto.neighbor_count());
    if (proto.neighbor_count() < kMinNeighborCount) {
      return InvalidOption("header.options.neighbor_count", value, absl::StrCat("at least ", kMinNeighborCount));
    }
    if (proto.neighbor_count() > limits.max_neighbor_count) {
      return MakeError(absl::StatusCode::kResourceExhausted,
                       {kReasonNeighborhoodTooLarge,
                        "header.options.neighbor_count",
                        value,
                        absl::StrCat("at most ", limits.max_neighbor_count, " (max_neighbor_count)"),
                        {}});
    }
    options.neighborhood = NeighborCount{proto.neighbor_count()};
  } else if (proto.has_radius()) {
    if (!std::isfinite(proto.radius()) || proto.radius() <= 0.0) {
      return InvalidOption("header.options.radius", NumberText(proto.radius()), "finite and above 0");
    }
    options.neighborhood = NeighborRadius{proto.radius()};
  } else if (proto.has_automatic_scale() || options.estimator == kAutomaticEstimator) {
    if (absl::Status status = ReadScale(proto.automatic_scale(), limits, options); !status.ok()) return status;
  }
  options.max_neighbor_count = limits.max_neighbor_count;
  return absl::OkStatus();
}

absl::Status ResolveEstimatorOptions(const v1::EstimatorOptions& proto, const CallLimits& limits,
                                     EstimatorOptions& options) {
  if (absl::Status status = ResolveEstimator(proto.estimator(), options.estimator); !status.ok()) return status;
  if (absl::Status status = ResolveNeighborhood(proto, limits, options); !status.ok()) return status;
  if (absl::Status status = ReadOptions(proto, options); !status.ok()) return status;
  if (options.is_automatic()) {
    if (absl::Status status = CheckChoice(options); !status.ok()) return status;
  }
  absl::Status status = options.Validate();
  return status.ok() ? status : InvalidOptionAt("header.options.", status);
}

absl::Status ResolveQuantities(const v1::CloudHeader& header, NormalSource normals, QuantitySet& set) {
  if (header.quantities().empty()) {
    if (normals != NormalSource::kGiven) set.Add(v1::QUANTITY_NORMALS);
    return absl::OkStatus();
  }
  set = QuantitySet::None();
  for (int i = 0; i < header.quantities_size(); ++i) {
    const std::string field = absl::StrCat("header.quantities[", i, "]");
    const v1::Quantity quantity = header.quantities(i);
    if (quantity == v1::QUANTITY_UNSPECIFIED || !v1::Quantity_IsValid(quantity)) {
      return InvalidOption(field, absl::StrCat(static_cast<int>(quantity)),
                           "a value of curvature.v1.Quantity other than UNSPECIFIED");
    }
    if (set.Has(quantity)) {
      return InvalidOption(field, absl::StrCat(static_cast<int>(quantity)), "given at most once");
    }
    set.Add(quantity);
  }
  return absl::OkStatus();
}

// Only an estimate of curvature looks for opposed normals.
absl::Status CheckRejection(const CallOptions& options) {
  if (options.estimator.opposed_normals != OpposedNormalsPolicy::kReject || options.quantities.HasCurvature()) {
    return absl::OkStatus();
  }
  return InvalidOption("header.opposed_normals_policy",
                       absl::StrCat(static_cast<int>(v1::OPPOSED_NORMALS_POLICY_REJECT)),
                       "1 (mark) or unset unless header.quantities holds a quantity of curvature");
}

// Only an estimate of curvature has scales.
absl::Status CheckCounts(const CallOptions& options) {
  if (!options.names_counts || options.quantities.HasCurvature()) return absl::OkStatus();
  return InvalidOption("header.options.neighbor_counts", "set",
                       "unset unless header.quantities holds a quantity of curvature");
}

// The one direction for all points, if the header has it.
absl::Status ResolveDirection(const v1::CloudHeader& header, CallOptions& options) {
  constexpr char kField[] = "header.curvature_direction";
  if (!header.has_curvature_direction()) return absl::OkStatus();
  const v1::Vector3& v = header.curvature_direction();
  const std::string value = VectorText(std::array{v.x(), v.y(), v.z()});
  if (!options.quantities.Has(v1::QUANTITY_NORMAL_CURVATURE)) {
    return InvalidOption(kField, value, "unset unless header.quantities has 13 (normal curvature)");
  }
  options.curvature_direction = DirectionOf({v.x(), v.y(), v.z()});
  if (options.curvature_direction != Direction{}) return absl::OkStatus();
  return InvalidOption(kField, value, "finite, and not of length 0");
}

absl::Status ResolveEnums(const v1::CloudHeader& header, CallOptions& options) {
  switch (header.scalar_type()) {
    case v1::SCALAR_TYPE_UNSPECIFIED:
    case v1::SCALAR_TYPE_FLOAT32:
      options.scalar_type = ScalarType::kFloat32;
      break;
    case v1::SCALAR_TYPE_FLOAT64:
      options.scalar_type = ScalarType::kFloat64;
      break;
    default:
      return InvalidOption("header.scalar_type", absl::StrCat(static_cast<int>(header.scalar_type())),
                           "1 (float32) or 2 (float64)");
  }
  switch (header.invalid_point_policy()) {
    case v1::INVALID_POINT_POLICY_UNSPECIFIED:
    case v1::INVALID_POINT_POLICY_REJECT:
      options.invalid_point_policy = InvalidPointPolicy::kReject;
      break;
    case v1::INVALID_POINT_POLICY_SKIP:
      options.invalid_point_policy = InvalidPointPolicy::kSkip;
      break;
    default:
      return InvalidOption("header.invalid_point_policy", absl::StrCat(static_cast<int>(header.invalid_point_policy())),
                           "1 (reject) or 2 (skip)");
  }
  switch (header.opposed_normals_policy()) {
    case v1::OPPOSED_NORMALS_POLICY_UNSPECIFIED:
    case v1::OPPOSED_NORMALS_POLICY_MARK:
      options.estimator.opposed_normals = OpposedNormalsPolicy::kMark;
      break;
    case v1::OPPOSED_NORMALS_POLICY_REJECT:
      options.estimator.opposed_normals = OpposedNormalsPolicy::kReject;
      break;
    default:
      return InvalidOption("header.opposed_normals_policy",
                           absl::StrCat(static_cast<int>(header.opposed_normals_policy())), "1 (mark) or 2 (reject)");
  }
  switch (header.priority()) {
    case v1::PRIORITY_UNSPECIFIED:
      break;
    case v1::PRIORITY_INTERACTIVE:
      options.priority = JobPriority::kInteractive;
      break;
    case v1::PRIORITY_BATCH:
      options.priority = JobPriority::kBatch;
      break;
    default:
      return InvalidOption("header.priority", absl::StrCat(static_cast<int>(header.priority())),
                           "1 (interactive) or 2 (batch)");
  }
  return absl::OkStatus();
}

absl::Status CheckOrigin(const v1::Vector3& origin) {
  const std::array<std::pair<const char*, double>, 3> coordinates = {
      {{"x", origin.x()}, {"y", origin.y()}, {"z", origin.z()}}};
  for (const auto& [name, value] : coordinates) {
    if (!std::isfinite(value)) {
      return InvalidOption(absl::StrCat("header.origin.", name), NumberText(value), "finite");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckTag(const std::string& tag) {
  if (tag.size() > kMaxTagBytes) {
    return InvalidOption("header.request_tag", absl::StrCat(tag.size(), " bytes"),
                         absl::StrCat("at most ", kMaxTagBytes, " bytes"));
  }
  for (size_t i = 0; i < tag.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(tag[i]);
    if (c < 0x20 || c > 0x7e) {
      return InvalidOption(absl::StrCat("header.request_tag[", i, "]"), absl::StrFormat("0x%02x", c),
                           "printable ASCII (0x20 to 0x7e)");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CallOptions> ResolveHeader(const v1::CloudHeader& header, const CallLimits& limits) {
  CallOptions options;
  if (header.point_count() > limits.max_points) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     {kReasonTooManyPoints,
                      "header.point_count",
                      absl::StrCat(header.point_count()),
                      absl::StrCat("at most ", limits.max_points, " (max_points)"),
                      {}});
  }
  options.point_count = header.point_count();
  options.marks_last_chunk = header.marks_last_chunk();
  if (absl::Status status = ResolveEnums(header, options); !status.ok()) return status;
  if (absl::Status status = CheckOrigin(header.origin()); !status.ok()) return status;
  if (absl::Status status = ResolveEstimatorOptions(header.options(), limits, options.estimator); !status.ok()) {
    return status;
  }
  options.names_counts = header.options().neighbor_counts_size() > 0;
  if (absl::Status status = ReadNormals(header.normals(), limits, options.normals); !status.ok()) return status;
  if (absl::Status status = ResolveQuantities(header, options.normals.source, options.quantities); !status.ok()) {
    return status;
  }
  if (absl::Status status = ResolveChoice(options.quantities, options.estimator); !status.ok()) return status;
  if (absl::Status status = ResolveDirection(header, options); !status.ok()) return status;
  if (absl::Status status = CheckRejection(options); !status.ok()) return status;
  if (absl::Status status = CheckCounts(options); !status.ok()) return status;
  options.normals.returns_normals = options.quantities.HasNormals();
  if (absl::Status status = CheckTag(header.request_tag()); !status.ok()) return status;
  options.request_tag = header.request_tag();
  if (absl::Status status = ReadPart(header.part(), options.part); !status.ok()) return status;
  if (options.part.has_roles && options.has_directions()) {
    return InvalidOption("header.part.has_roles", "true",
                         "false unless header.curvature_direction is set: results are those of the queries alone");
  }
  return options;
}

std::optional<uint32_t> LeastNeighborCount(const CallOptions& options) {
  if (!options.quantities.HasCurvature()) {
    const auto* const count = std::get_if<NeighborCount>(&options.normals.neighborhood);
    return count == nullptr ? std::nullopt : std::optional(count->count);
  }
  const EstimatorOptions least = options.estimator.AtScale(options.estimator.scale_count() - 1);
  if (const auto* const scale = std::get_if<AutomaticScale>(&least.neighborhood)) return scale->least_count;
  const auto* const count = std::get_if<NeighborCount>(&least.neighborhood);
  return count == nullptr ? std::nullopt : std::optional(count->count);
}

void FillAccepted(const CallOptions& options, const CallLimits& limits, const std::string& request_id,
                  v1::Accepted* accepted) {
  accepted->set_request_id(request_id);
  FillLimits(limits, accepted->mutable_limits());
  v1::EstimatorOptions* proto = accepted->mutable_options();
  const bool is_auto = options.estimator.estimator == kAutomaticEstimator;
  proto->set_estimator(is_auto ? v1::ESTIMATOR_AUTO : WireEstimator(*FindStrategy(options.estimator.estimator)));
  if (const auto* scale = std::get_if<AutomaticScale>(&options.estimator.neighborhood)) {
    WriteScale(*scale, *proto->mutable_automatic_scale());
  } else if (const auto* radius = std::get_if<NeighborRadius>(&options.estimator.neighborhood)) {
    proto->set_radius(radius->radius);
  } else if (options.names_counts) {
    WriteCounts(options.estimator, *proto);
  } else {
    proto->set_neighbor_count(std::get<NeighborCount>(options.estimator.neighborhood).count);
  }
  WriteOptions(options.estimator, *proto);
  WriteNormals(options.normals, *accepted->mutable_normals());
  WritePart(options.part, *accepted->mutable_part());
  const std::optional<double> reach = ReachFactor(options.estimator);
  const bool is_local = options.normals.source == NormalSource::kGiven && !options.estimator.returns_choice;
  if (reach.has_value() && is_local) accepted->set_reach_factor(*reach);
  for (const v1::Quantity quantity : curvature::wire::Quantities()) {
    if (options.quantities.Has(quantity)) accepted->add_quantities(quantity);
  }
}

void FillLimits(const CallLimits& limits, v1::ServerLimits* proto) {
  proto->set_max_points(limits.max_points);
  proto->set_max_chunk_bytes(limits.max_chunk_bytes);
  proto->set_max_neighbor_count(limits.max_neighbor_count);
  proto->set_memory_bytes(limits.memory_bytes);
  proto->set_max_streams(limits.max_streams);
}

void FillEstimators(v1::GetServerInfoResponse* info) {
  for (const Strategy* strategy : Strategies()) {
    const v1::Estimator estimator = WireEstimator(*strategy);
    if (estimator != v1::ESTIMATOR_UNSPECIFIED) info->add_estimators(estimator);
  }
  info->add_estimators(v1::ESTIMATOR_AUTO);
}

}  // namespace curvd
