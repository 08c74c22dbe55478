#include "server/call/call_options.h"

#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "proto/result_columns.h"
#include "server/call/error_detail.h"
#include "server/call/reasons.h"
#include "server/call/wire_estimators.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr size_t kMaxTagBytes = 128;

absl::Status InvalidOption(std::string field, std::string value, std::string limit) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   {kReasonInvalidOption, std::move(field), std::move(value), std::move(limit), {}});
}

absl::Status ResolveEstimator(v1::Estimator proto, EstimatorKind& kind) {
  if (proto == v1::ESTIMATOR_UNSPECIFIED) return absl::OkStatus();
  for (const WireEstimator& name : kWireEstimators) {
    if (name.proto != proto) continue;
    kind = name.kind;
    return absl::OkStatus();
  }
  return InvalidOption("header.options.estimator", absl::StrCat(static_cast<int>(proto)),
                       "a value of curvature.v1.Estimator that this server knows");
}

absl::Status ResolveNeighborhood(const v1::EstimatorOptions& proto, const CallLimits& limits,
                                 EstimatorOptions& options) {
  if (proto.has_neighbor_count()) {
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
      return InvalidOption("header.options.radius", absl::StrCat(proto.radius()), "finite and above 0");
    }
    options.neighborhood = NeighborRadius{proto.radius()};
  }
  options.max_neighbor_count = limits.max_neighbor_count;
  return absl::OkStatus();
}

absl::Status ResolveEstimatorOptions(const v1::EstimatorOptions& proto, const CallLimits& limits,
                                     EstimatorOptions& options) {
  if (absl::Status status = ResolveEstimator(proto.estimator(), options.estimator); !status.ok()) return status;
  if (absl::Status status = ResolveNeighborhood(proto, limits, options); !status.ok()) return status;
  if (proto.triangle_count() > kMaxTriangleCount) {
    return InvalidOption("header.options.triangle_count", absl::StrCat(proto.triangle_count()),
                         absl::StrCat("at most ", kMaxTriangleCount));
  }
  if (proto.triangle_count() != 0) options.triangle_count = proto.triangle_count();
  if (proto.rotation_count() > kMaxRotations) {
    return InvalidOption("header.options.rotation_count", absl::StrCat(proto.rotation_count()),
                         absl::StrCat("at most ", kMaxRotations));
  }
  if (proto.rotation_count() != 0) options.rotation_count = proto.rotation_count();
  if (proto.jet_degree() != 0) {
    if (proto.jet_degree() < kMinJetDegree || proto.jet_degree() > kMaxJetDegree) {
      return InvalidOption("header.options.jet_degree", absl::StrCat(proto.jet_degree()),
                           absl::StrCat("from ", kMinJetDegree, " to ", kMaxJetDegree));
    }
    options.jet_degree = proto.jet_degree();
  }
  options.even_weights = proto.even_weights();
  options.seed = proto.seed();
  if (proto.has_average_normal_weight()) {
    const double weight = proto.average_normal_weight();
    if (!(weight >= 0.0 && weight <= 1.0)) {
      return InvalidOption("header.options.average_normal_weight", absl::StrCat(weight), "in [0, 1]");
    }
    options.average_normal_weight = weight;
  }
  absl::Status status = options.Validate();
  if (!status.ok()) return WithDetail(std::move(status), {kReasonInvalidOption, "header.options", "", "", {}});
  return status;
}

absl::Status ResolveQuantities(const v1::CloudHeader& header, QuantitySet& set) {
  if (header.quantities().empty()) return absl::OkStatus();
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
      return InvalidOption(absl::StrCat("header.origin.", name), absl::StrCat(value), "finite");
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
  if (absl::Status status = ResolveEnums(header, options); !status.ok()) return status;
  if (absl::Status status = CheckOrigin(header.origin()); !status.ok()) return status;
  if (absl::Status status = ResolveEstimatorOptions(header.options(), limits, options.estimator); !status.ok()) {
    return status;
  }
  if (absl::Status status = ResolveQuantities(header, options.quantities); !status.ok()) return status;
  if (absl::Status status = CheckTag(header.request_tag()); !status.ok()) return status;
  options.request_tag = header.request_tag();
  return options;
}

void FillAccepted(const CallOptions& options, const CallLimits& limits, const std::string& request_id,
                  v1::Accepted* accepted) {
  accepted->set_request_id(request_id);
  FillLimits(limits, accepted->mutable_limits());
  v1::EstimatorOptions* proto = accepted->mutable_options();
  for (const WireEstimator& name : kWireEstimators) {
    if (name.kind == options.estimator.estimator) proto->set_estimator(name.proto);
  }
  if (const auto* radius = std::get_if<NeighborRadius>(&options.estimator.neighborhood)) {
    proto->set_radius(radius->radius);
  } else {
    proto->set_neighbor_count(std::get<NeighborCount>(options.estimator.neighborhood).count);
  }
  proto->set_triangle_count(options.estimator.triangle_count);
  proto->set_rotation_count(options.estimator.rotation_count);
  proto->set_jet_degree(options.estimator.jet_degree);
  proto->set_even_weights(options.estimator.even_weights);
  proto->set_seed(options.estimator.seed);
  proto->set_average_normal_weight(options.estimator.average_normal_weight);
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
  for (const WireEstimator& name : kWireEstimators) info->add_estimators(name.proto);
}

}  // namespace curvd
