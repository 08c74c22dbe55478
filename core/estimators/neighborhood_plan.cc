#include "core/estimators/neighborhood_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/number_text.h"

namespace curvd {

SearchPlan SearchSizes(const EstimatorOptions& options, size_t most_searched) {
  if (std::holds_alternative<NeighborRadius>(options.neighborhood)) {
    return SearchPlan::ByRadius(0.0f, options.max_neighbor_count);
  }
  const auto* const scale = std::get_if<AutomaticScale>(&options.neighborhood);
  const size_t count = scale != nullptr ? scale->most_count : std::get<NeighborCount>(options.neighborhood).count;
  return SearchPlan::ByCount(std::min(count, most_searched));
}

size_t MostNeighbors(const EstimatorOptions& options, size_t point_count) {
  return SearchSizes(options).MostNeighbors(point_count);
}

NeighborhoodPlan NeighborhoodPlan::Make(const EstimatorOptions& options, const SpatialIndex& index,
                                        size_t most_searched) {
  constexpr double kWholeIndex = 0x1p126;  // above the squared diagonal of any index: SpatialIndex::kFarthest
  NeighborhoodPlan plan{};
  plan.search = SearchSizes(options, most_searched);
  plan.average_normal_weight = static_cast<float>(options.average_normal_weight);
  plan.scale = std::ldexp(1.0, index.scale_exponent());
  plan.half_scale = std::ldexp(1.0f, index.scale_exponent() / 2);
  plan.other_half_scale = std::ldexp(1.0f, index.scale_exponent() - index.scale_exponent() / 2);
  plan.radius_factor = 1.0f;
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) {
    plan.radius = radius->radius;
    const double scaled = radius->radius * plan.scale;
    plan.search.squared_radius = static_cast<float>(std::min(scaled * scaled, kWholeIndex));
    plan.least_count = kMinNeighborCount;
  } else {
    const size_t count = std::get<NeighborCount>(options.neighborhood).count;
    plan.least_count = plan.search.searched_count;
    plan.radius_factor = static_cast<float>(std::sqrt(static_cast<double>(count) / plan.search.searched_count));
  }
  plan.rho_factor = plan.radius_factor;
  return plan;
}

absl::Status Stopped() { return MakeCoreError(ErrorKind::kCancelled, "cancelled while a neighborhood was searched"); }

absl::Status NeighborhoodTooLarge(const NeighborhoodPlan& plan, size_t point) {
  const std::string radius = NumberText(plan.radius);
  return MakeCoreError(
      ErrorKind::kNeighborhoodTooLarge,
      absl::StrCat("radius ", radius, " gives point ", point, " more than ", plan.search.max_neighbor_count,
                   " neighbors, the limit of this server; use a smaller radius, or neighbor_count"),
      {"radius", radius,
       absl::StrCat("so small that no point has more than ", plan.search.max_neighbor_count,
                    " neighbors (max_neighbor_count)"),
       absl::StrCat(point)});
}

}  // namespace curvd
