#include "server/call/scale/wire_scale.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <variant>

#include "absl/strings/str_cat.h"
#include "core/base/number_text.h"
#include "core/estimators/scale_ladder.h"
#include "core/estimators/strategies.h"
#include "core/normals/trust/fitted_normals.h"
#include "server/call/invalid_option.h"
#include "server/call/wire_normals.h"
#include "server/call/wire_strategies.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

std::string ScaleField(const char* name) { return absl::StrCat("header.options.automatic_scale.", name); }

// The most that this server takes.
uint32_t MostCount(const CallLimits& limits) {
  return std::min(kMostAutomaticCount, std::max(kLeastAutomaticCount, limits.max_neighbor_count));
}

// `names_most`: whether the caller has set most_neighbor_count, or the server.
absl::Status CheckCounts(const AutomaticScale& scale, bool names_most, const CallLimits& limits) {
  if (scale.most_count < kLeastAutomaticCount || scale.most_count > kMostAutomaticCount) {
    return InvalidOption(ScaleField("most_neighbor_count"), absl::StrCat(scale.most_count),
                         absl::StrCat("from ", kLeastAutomaticCount, " to ", MostCount(limits),
                                      MostCount(limits) < kMostAutomaticCount ? " (max_neighbor_count)" : ""));
  }
  if (scale.least_count < kLeastAutomaticCount || scale.least_count > scale.most_count) {
    const char* reason = names_most                               ? " (most_neighbor_count)"
                         : scale.most_count < kMostAutomaticCount ? " (max_neighbor_count)"
                                                                  : "";
    return InvalidOption(ScaleField("least_neighbor_count"), absl::StrCat(scale.least_count),
                         absl::StrCat("from ", kLeastAutomaticCount, " to ", scale.most_count, reason));
  }
  if (scale.most_count <= limits.max_neighbor_count) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   {kReasonNeighborhoodTooLarge,
                    ScaleField("most_neighbor_count"),
                    absl::StrCat(scale.most_count),
                    absl::StrCat("at most ", limits.max_neighbor_count, " (max_neighbor_count)"),
                    {}});
}

// The first row of an estimator.
const ScaleMethod* MethodOf(std::string_view estimator) {
  for (const ScaleMethod& method : kScaleMethods) {
    if (method.estimator == estimator && FindStrategy(estimator) != nullptr) return &method;
  }
  return nullptr;
}

// "auto, avg-hexagram or jet": the estimators that the choice knows, as far as there are any of the name.
std::string KnownEstimators() {
  std::string last(kAutomaticEstimator), words;
  for (const ScaleMethod& method : kScaleMethods) {
    if (MethodOf(method.estimator) != &method) continue;
    absl::StrAppend(&words, words.empty() ? "" : ", ", last);
    last = std::string(method.estimator);
  }
  return absl::StrCat(words, " or ", last);
}

}  // namespace

absl::Status ReadScale(const v1::AutomaticScale& proto, const CallLimits& limits, EstimatorOptions& options) {
  AutomaticScale scale;
  scale.per_cloud = proto.per_cloud();
  scale.max_radius = proto.max_radius();
  if (!std::isfinite(scale.max_radius) || scale.max_radius < 0.0) {
    return InvalidOption(ScaleField("max_radius"), NumberText(scale.max_radius), "finite, and 0 or more");
  }
  if (proto.least_neighbor_count() != 0) scale.least_count = proto.least_neighbor_count();
  const bool names_most = proto.most_neighbor_count() != 0;
  scale.most_count = names_most ? proto.most_neighbor_count() : MostCount(limits);
  if (absl::Status status = CheckCounts(scale, names_most, limits); !status.ok()) return status;
  options.neighborhood = scale;
  const ScaleMethod* method = MethodOf(options.estimator);
  if (method != nullptr && method->is_jet()) options.jet_degree = method->degree;
  if (method != nullptr && method->is_sphere()) options.project = true;
  return absl::OkStatus();
}

absl::Status CheckChoice(const EstimatorOptions& options) {
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) {
    return InvalidOption("header.options.radius", NumberText(radius->radius),
                         "unset where the estimator is auto, which knows automatic_scale.max_radius");
  }
  if (options.estimator == kAutomaticEstimator) return absl::OkStatus();
  return CheckMethod(options, "where automatic_scale is set");
}

absl::Status CheckMethod(const EstimatorOptions& options, std::string_view where) {
  const ScaleMethod* method = MethodOf(options.estimator);
  if (method == nullptr) {
    return InvalidOption("header.options.estimator", std::string(options.estimator),
                         absl::StrCat(KnownEstimators(), " ", std::string(where)));
  }
  if (method->is_jet() && options.jet_degree != method->degree) {
    return InvalidOption("header.options.jet_degree", absl::StrCat(options.jet_degree),
                         absl::StrCat(method->degree, " ", std::string(where)));
  }
  if (method->is_sphere() && !options.project) {
    return InvalidOption("header.options.project", "false", absl::StrCat("true ", std::string(where)));
  }
  return absl::OkStatus();
}

void WriteScale(const AutomaticScale& scale, v1::AutomaticScale& proto) {
  proto.set_least_neighbor_count(scale.least_count);
  proto.set_most_neighbor_count(scale.most_count);
  proto.set_max_radius(scale.max_radius);
  proto.set_per_cloud(scale.per_cloud);
}

void WriteReport(const ScaleReport& report, v1::ScaleReport& proto) {
  for (const ScaleOutcome& outcome : report.outcomes) {
    v1::ScaleOutcome& one = *proto.add_outcomes();
    one.set_estimator(WireEstimator(*FindStrategy(outcome.estimator)));
    one.set_degree(outcome.degree);
    one.set_neighbor_count(outcome.neighbor_count);
    one.set_error(outcome.error);
    one.set_noise(outcome.noise);
    one.set_bias(outcome.bias);
    one.set_share(outcome.share);
  }
  proto.set_sampled_point_count(report.sampled_points);
  proto.set_position_noise(report.sigma);
  if (report.normal_sigma.has_value()) proto.set_normal_noise(*report.normal_sigma);
  const auto set_fit = [](const FittedNormals& fit, v1::FittedNormals& to) {
    to.set_method(WireNormalMethod(fit.method));
    to.set_neighbor_count(fit.neighbor_count);
  };
  if (report.fitted_normals.has_value()) set_fit(*report.fitted_normals, *proto.mutable_fitted_normals());
  if (report.normals_made_anew.has_value()) set_fit(*report.normals_made_anew, *proto.mutable_normals_made_anew());
}

}  // namespace curvd
