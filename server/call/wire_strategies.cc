#include "server/call/wire_strategies.h"

#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "core/estimators/strategies.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

std::string WireName(const Strategy& strategy) {
  if (!strategy.wire_name.empty()) return absl::StrCat("ESTIMATOR_", std::string(strategy.wire_name));
  return absl::AsciiStrToUpper(
      absl::StrCat("ESTIMATOR_", absl::StrReplaceAll(std::string(strategy.name), {{"-", "_"}})));
}

}  // namespace

v1::Estimator WireEstimator(const Strategy& strategy) {
  v1::Estimator estimator = v1::ESTIMATOR_UNSPECIFIED;
  v1::Estimator_Parse(WireName(strategy), &estimator);
  return estimator;
}

const Strategy* StrategyOf(v1::Estimator estimator) {
  if (estimator == v1::ESTIMATOR_UNSPECIFIED) return nullptr;
  for (const Strategy* strategy : Strategies()) {
    if (WireEstimator(*strategy) == estimator) return strategy;
  }
  return nullptr;
}

}  // namespace curvd
