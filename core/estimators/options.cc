#include "core/estimators/options.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/error.h"
#include "core/estimators/option_specs.h"
#include "core/estimators/strategies.h"

namespace curvd {
namespace {

absl::Status ValidateEstimator(std::string_view estimator) {
  if (FindStrategy(estimator) != nullptr) return absl::OkStatus();
  return MakeCoreError(ErrorKind::kInvalid,
                       absl::StrFormat("estimator is \"%s\"; it must be one of %s", estimator, StrategyNames()));
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

}  // namespace

absl::Status EstimatorOptions::Validate() const {
  absl::Status status = ValidateEstimator(estimator);
  if (!status.ok()) return status;
  if (const auto* count = std::get_if<NeighborCount>(&neighborhood)) {
    status = ValidateCount(count->count, max_neighbor_count);
  } else {
    status = ValidateRadius(std::get<NeighborRadius>(neighborhood).radius);
  }
  if (!status.ok()) return status;
  for (const OptionSpec& spec : OptionSpecs()) {
    if (spec.InRange(*this)) continue;
    return MakeCoreError(ErrorKind::kInvalid, absl::StrFormat("%s is %s; it must be from %g to %g", spec.name,
                                                              spec.ValueText(*this), spec.least, spec.most));
  }
  return absl::OkStatus();
}

}  // namespace curvd
