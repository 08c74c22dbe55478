#include "core/estimators/options.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/estimators/option_specs.h"
#include "core/estimators/scale_ladder.h"
#include "core/estimators/strategies.h"

namespace curvd {
namespace {

absl::Status ValidateEstimator(std::string_view estimator) {
  if (estimator == kAutomaticEstimator) return absl::OkStatus();
  if (FindStrategy(estimator) != nullptr) return absl::OkStatus();
  return InvalidValue("estimator", std::string(estimator), absl::StrCat("auto, or one of ", StrategyNames()));
}

absl::Status ValidateCount(uint32_t count, uint32_t max_count) {
  if (count >= kMinNeighborCount && count <= max_count) return absl::OkStatus();
  return InvalidValue("neighbor_count", absl::StrCat(count),
                      absl::StrCat("from ", kMinNeighborCount, " to ", max_count));
}

absl::Status ValidateRadius(double radius) {
  // Results have it as a float.
  if (radius > 0.0 && radius <= std::numeric_limits<float>::max()) return absl::OkStatus();
  return InvalidValue("radius", NumberText(radius), "greater than 0, and at most 3.4028e38");
}

// A count whose estimates a sample of the cloud can judge.
absl::Status ValidateJudgedCount(uint32_t count, const char* with) {
  if (count >= kLeastAutomaticCount && count <= kMostAutomaticCount) return absl::OkStatus();
  return InvalidValue("neighbor_count", absl::StrCat(count),
                      absl::StrCat("from ", kLeastAutomaticCount, " to ", kMostAutomaticCount, " with ", with));
}

// The estimators that a choice knows, with what it takes of them.
absl::Status ValidateAutomatic(const EstimatorOptions& options) {
  if (options.estimator == kAutomaticEstimator) {
    if (std::holds_alternative<NeighborRadius>(options.neighborhood)) {
      return InvalidValue("neighborhood", "a radius", "a neighbor_count or automatic with estimator auto");
    }
    const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
    return count == nullptr ? absl::OkStatus() : ValidateJudgedCount(count->count, "estimator auto");
  }
  for (const ScaleMethod& method : kScaleMethods) {
    if (options.estimator != method.estimator) continue;
    if (method.is_sphere() && !options.project) {
      return InvalidValue("project", "false", "true with aso and an automatic scale or standard errors");
    }
    if (!method.is_jet() || options.jet_degree == method.degree) return absl::OkStatus();
    return InvalidValue("jet_degree", absl::StrCat(options.jet_degree),
                        absl::StrCat(method.degree, " with an automatic scale or standard errors"));
  }
  std::string known;
  for (const ScaleMethod& method : kScaleMethods) {
    const std::string name = absl::StrCat(", ", std::string(method.estimator));
    if (!absl::StrContains(known, name)) known += name;
  }
  return InvalidValue(
      "estimator", std::string(options.estimator),
      absl::StrCat("one of ", std::string(kAutomaticEstimator), known, " with an automatic scale or standard errors"));
}

// A fixed estimate of which a sample can tell how sure it is.
absl::Status ValidateChoice(const EstimatorOptions& options) {
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  if (count == nullptr) {
    return InvalidValue("neighborhood", "a radius", "a neighbor_count or automatic with standard errors");
  }
  return ValidateJudgedCount(count->count, "standard errors");
}

absl::Status ValidateScale(const AutomaticScale& scale, uint32_t max_neighbor_count) {
  const uint32_t most = std::min(kMostAutomaticCount, max_neighbor_count);
  if (scale.most_count < kLeastAutomaticCount || scale.most_count > most) {
    return InvalidValue("most_count", absl::StrCat(scale.most_count),
                        absl::StrCat("from ", kLeastAutomaticCount, " to ", most));
  }
  if (scale.least_count < kLeastAutomaticCount || scale.least_count > scale.most_count) {
    return InvalidValue("least_count", absl::StrCat(scale.least_count),
                        absl::StrCat("from ", kLeastAutomaticCount, " to most_count, ", scale.most_count));
  }
  if (std::isfinite(scale.max_radius) && scale.max_radius >= 0.0) return absl::OkStatus();
  return InvalidValue("max_radius", NumberText(scale.max_radius), "finite, and 0 or more");
}

absl::Status ValidateScales(const EstimatorOptions& options) {
  if (options.smaller_counts.size == 0) return absl::OkStatus();
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  if (count == nullptr || options.returns_choice) {
    return InvalidValue("smaller_counts", "set",
                        "unset unless the neighborhood is a neighbor_count, without standard errors");
  }
  const Strategy* strategy = FindStrategy(options.estimator);
  if (strategy == nullptr || strategy->start_scales == nullptr) {
    return InvalidValue("estimator", std::string(options.estimator),
                        absl::StrCat("one of ", ScaledStrategyNames(), " with several neighbor counts"));
  }
  if (options.smaller_counts.size >= kMaxScales) {
    return InvalidValue("smaller_counts", absl::StrCat("a list of ", options.smaller_counts.size),
                        absl::StrCat("a list of at most ", kMaxScales - 1));
  }
  uint32_t above = count->count;
  for (const uint32_t smaller : options.smaller_counts.span()) {
    if (smaller >= kMinNeighborCount && smaller < above) {
      above = smaller;
      continue;
    }
    return InvalidValue("one of smaller_counts", absl::StrCat(smaller),
                        absl::StrCat("from ", kMinNeighborCount, " to ", above - 1));
  }
  return absl::OkStatus();
}

}  // namespace

EstimatorOptions EstimatorOptions::AtScale(size_t scale) const {
  EstimatorOptions options = *this;
  options.smaller_counts = {};
  if (scale > 0) options.neighborhood = NeighborCount{smaller_counts.counts[scale - 1]};
  return options;
}

EstimatorOptions EstimatorOptions::FromScale(size_t scale) const {
  EstimatorOptions options = AtScale(scale);
  for (const uint32_t count : smaller_counts.span().subspan(scale)) {
    options.smaller_counts.counts[options.smaller_counts.size++] = count;
  }
  return options;
}

absl::Status EstimatorOptions::Validate() const {
  absl::Status status = ValidateEstimator(estimator);
  if (!status.ok()) return status;
  if (const auto* count = std::get_if<NeighborCount>(&neighborhood)) {
    status = ValidateCount(count->count, max_neighbor_count);
  } else if (const auto* scale = std::get_if<AutomaticScale>(&neighborhood)) {
    status = ValidateScale(*scale, max_neighbor_count);
  } else {
    status = ValidateRadius(std::get<NeighborRadius>(neighborhood).radius);
  }
  if (!status.ok()) return status;
  if (returns_choice && !is_automatic()) status = ValidateChoice(*this);
  if (!status.ok()) return status;
  if (is_automatic() || returns_choice) status = ValidateAutomatic(*this);
  if (!status.ok()) return status;
  status = ValidateScales(*this);
  if (!status.ok()) return status;
  for (const OptionSpec& spec : OptionSpecs()) {
    if (spec.InRange(*this)) continue;
    return InvalidValue(std::string(spec.name), spec.ValueText(*this),
                        absl::StrCat("from ", NumberText(spec.least), " to ", NumberText(spec.most)));
  }
  return absl::OkStatus();
}

}  // namespace curvd
