#include "core/estimators/options.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/error.h"
#include "core/estimators/option_specs.h"
#include "core/estimators/scale_ladder.h"
#include "core/estimators/strategies.h"

namespace curvd {
namespace {

absl::Status ValidateEstimator(std::string_view estimator) {
  if (estimator == kAutomaticEstimator) return absl::OkStatus();
  if (FindStrategy(estimator) != nullptr) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("estimator is \"%s\"; it must be auto, or one of %s",
                                                            estimator, StrategyNames()));
}

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

// A count whose estimates a sample of the cloud can judge.
absl::Status ValidateJudgedCount(uint32_t count, std::string_view with) {
  if (count >= kLeastAutomaticCount && count <= kMostAutomaticCount) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("neighbor_count is %u; with %s it must be from %u to %u",
                                                            count, with, kLeastAutomaticCount, kMostAutomaticCount));
}

// The estimators that a choice knows, with what it takes of them.
absl::Status ValidateAutomatic(const EstimatorOptions& options) {
  if (options.estimator == kAutomaticEstimator) {
    if (std::holds_alternative<NeighborRadius>(options.neighborhood)) {
      return MakeCoreError(ErrorKind::kInvalid,
                           "neighborhood is a radius; with estimator auto it must be a neighbor_count or automatic");
    }
    const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
    return count == nullptr ? absl::OkStatus() : ValidateJudgedCount(count->count, "estimator auto");
  }
  for (const ScaleMethod& method : kScaleMethods) {
    if (options.estimator != method.estimator) continue;
    if (method.is_sphere() && !options.project) {
      return MakeCoreError(ErrorKind::kInvalid,
                           "project is false; with aso and an automatic scale or standard errors it must be true");
    }
    if (!method.is_jet() || options.jet_degree == method.degree) return absl::OkStatus();
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrFormat("jet_degree is %u; with an automatic scale or standard errors it must be %u",
                                         options.jet_degree, method.degree));
  }
  std::string known;
  for (const ScaleMethod& method : kScaleMethods) {
    const std::string name = absl::StrCat(", ", std::string(method.estimator));
    if (!absl::StrContains(known, name)) known += name;
  }
  return MakeCoreError(
      ErrorKind::kInvalid,
      absl::StrFormat("estimator is \"%s\"; with an automatic scale or standard errors it must be one of %s%s",
                      options.estimator, kAutomaticEstimator, known));
}

// A fixed estimate of which a sample can tell how sure it is.
absl::Status ValidateChoice(const EstimatorOptions& options) {
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  if (count == nullptr) {
    return MakeCoreError(ErrorKind::kInvalid,
                         "neighborhood is a radius; with standard errors it must be a neighbor_count or automatic");
  }
  return ValidateJudgedCount(count->count, "standard errors");
}

absl::Status ValidateScale(const AutomaticScale& scale, uint32_t max_neighbor_count) {
  const uint32_t most = std::min(kMostAutomaticCount, max_neighbor_count);
  if (scale.most_count < kLeastAutomaticCount || scale.most_count > most) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("most_count is %u; it must be from %u to %u",
                                                              scale.most_count, kLeastAutomaticCount, most));
  }
  if (scale.least_count < kLeastAutomaticCount || scale.least_count > scale.most_count) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrFormat("least_count is %u; it must be from %u to most_count, %u", scale.least_count,
                                         kLeastAutomaticCount, scale.most_count));
  }
  if (std::isfinite(scale.max_radius) && scale.max_radius >= 0.0) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid,
                       absl::StrFormat("max_radius is %g; it must be finite, and 0 or more", scale.max_radius));
}

absl::Status ValidateScales(const EstimatorOptions& options) {
  if (options.smaller_counts.size == 0) return absl::OkStatus();
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  if (count == nullptr || options.returns_choice) {
    return MakeCoreError(ErrorKind::kInvalid,
                         "smaller_counts are set; the neighborhood must be a neighbor_count, without standard errors");
  }
  const Strategy* strategy = FindStrategy(options.estimator);
  if (strategy == nullptr || strategy->start_scales == nullptr) {
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrFormat("estimator is \"%s\"; with several neighbor counts it must be one of %s",
                                         options.estimator, ScaledStrategyNames()));
  }
  if (options.smaller_counts.size >= kMaxScales) {
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("there are %u smaller_counts; there must be at most %u",
                                                              options.smaller_counts.size, kMaxScales - 1));
  }
  uint32_t above = count->count;
  for (const uint32_t smaller : options.smaller_counts.span()) {
    if (smaller >= kMinNeighborCount && smaller < above) {
      above = smaller;
      continue;
    }
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("a smaller count is %u; it must be from %u to %u",
                                                              smaller, kMinNeighborCount, above - 1));
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
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("%s is %s; it must be from %g to %g", spec.name,
                                                              spec.ValueText(*this), spec.least, spec.most));
  }
  return absl::OkStatus();
}

}  // namespace curvd
