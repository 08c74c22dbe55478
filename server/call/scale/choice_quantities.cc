#include "server/call/scale/choice_quantities.h"

#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "core/base/number_text.h"
#include "server/call/invalid_option.h"
#include "server/call/scale/wire_scale.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

// What standard errors need of an estimate that is not left open.
absl::Status CheckFixed(const EstimatorOptions& options) {
  constexpr char kWhere[] = "where header.quantities has 10 (standard errors)";
  if (options.scale_count() > 1) {
    return InvalidOption("header.options.neighbor_counts", absl::StrCat("a list of ", options.scale_count()),
                         absl::StrCat("a list of one ", kWhere));
  }
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) {
    return InvalidOption("header.options.radius", NumberText(radius->radius), absl::StrCat("unset ", kWhere));
  }
  const uint32_t count = std::get<NeighborCount>(options.neighborhood).count;
  if (count < kLeastAutomaticCount || count > kMostAutomaticCount) {
    return InvalidOption("header.options.neighbor_count", absl::StrCat(count),
                         absl::StrCat("from ", kLeastAutomaticCount, " to ", kMostAutomaticCount, " ", kWhere));
  }
  return CheckMethod(options, kWhere);
}

}  // namespace

absl::Status ResolveChoice(const QuantitySet& quantities, EstimatorOptions& options) {
  if (!quantities.HasChoice()) return absl::OkStatus();
  constexpr std::pair<v1::Quantity, const char*> kChosen[] = {
      {v1::QUANTITY_CHOSEN_NEIGHBOR_COUNT, "11 (chosen neighbor count)"},
      {v1::QUANTITY_ESTIMATOR_WEIGHTS, "12 (estimator weights)"},
  };
  for (const auto& [quantity, name] : kChosen) {
    if (!quantities.Has(quantity) || options.is_automatic()) continue;
    return InvalidOption("header.quantities", name,
                         "without what is chosen, unless the estimator or the neighbor count is auto");
  }
  if (!options.is_automatic()) {
    if (absl::Status status = CheckFixed(options); !status.ok()) return status;
  }
  options.returns_choice = true;
  return absl::OkStatus();
}

}  // namespace curvd
