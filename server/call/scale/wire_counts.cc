#include "server/call/scale/wire_counts.h"

#include <algorithm>
#include <string>
#include <variant>

#include "absl/strings/str_cat.h"
#include "core/estimators/strategies.h"
#include "server/call/invalid_option.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr char kField[] = "header.options.neighbor_counts";

absl::Status CheckCount(const v1::EstimatorOptions& proto, int i, const CallLimits& limits) {
  const uint32_t count = proto.neighbor_counts(i);
  const std::string field = absl::StrCat(kField, "[", i, "]"), value = absl::StrCat(count);
  if (count < kMinNeighborCount) return InvalidOption(field, value, absl::StrCat("at least ", kMinNeighborCount));
  if (i > 0 && count <= proto.neighbor_counts(i - 1)) {
    return InvalidOption(field, value, absl::StrCat("above the count before it, ", proto.neighbor_counts(i - 1)));
  }
  if (count <= limits.max_neighbor_count) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   {kReasonNeighborhoodTooLarge,
                    field,
                    value,
                    absl::StrCat("at most ", limits.max_neighbor_count, " (max_neighbor_count)"),
                    {}});
}

absl::Status CheckEstimator(const EstimatorOptions& options) {
  const Strategy* strategy = FindStrategy(options.estimator);
  if (strategy != nullptr && strategy->start_scales != nullptr) return absl::OkStatus();
  return InvalidOption("header.options.estimator", std::string(options.estimator),
                       absl::StrCat("one of ", ScaledStrategyNames(), " where ", kField, " has several counts"));
}

}  // namespace

absl::Status ReadCounts(const v1::EstimatorOptions& proto, const CallLimits& limits, EstimatorOptions& options) {
  const int size = proto.neighbor_counts_size();
  if (proto.neighborhood_case() != v1::EstimatorOptions::NEIGHBORHOOD_NOT_SET) {
    return InvalidOption(kField, absl::StrCat("a list of ", size),
                         "unset where neighbor_count, radius or automatic_scale is set");
  }
  if (static_cast<size_t>(size) > kMaxScales) {
    return InvalidOption(kField, absl::StrCat("a list of ", size), absl::StrCat("a list of at most ", kMaxScales));
  }
  for (int i = 0; i < size; ++i) {
    if (absl::Status status = CheckCount(proto, i, limits); !status.ok()) return status;
  }
  if (size > 1) {
    if (absl::Status status = CheckEstimator(options); !status.ok()) return status;
  }
  options.neighborhood = NeighborCount{proto.neighbor_counts(size - 1)};
  options.smaller_counts.size = static_cast<size_t>(size - 1);
  std::reverse_copy(proto.neighbor_counts().begin(), proto.neighbor_counts().end() - 1,
                    options.smaller_counts.counts.begin());
  return absl::OkStatus();
}

void WriteCounts(const EstimatorOptions& options, v1::EstimatorOptions& proto) {
  for (size_t scale = options.scale_count(); scale-- > 0;) {
    proto.add_neighbor_counts(std::get<NeighborCount>(options.AtScale(scale).neighborhood).count);
  }
}

}  // namespace curvd
