#include "core/estimators/strategies.h"

#include <algorithm>
#include <array>

namespace curvd {

// The rows, each beside its kernel.
extern const Strategy kAvgHexagram;
extern const Strategy kHexagram;
extern const Strategy kUniform;
extern const Strategy kIndependent;
extern const Strategy kDelaunay;
extern const Strategy kJet;
extern const Strategy kAso;
extern const Strategy kNormalRegression;

std::span<const Strategy* const> Strategies() {
  static constexpr std::array<const Strategy*, 8> kStrategies = {
      &kAvgHexagram, &kHexagram, &kUniform, &kIndependent, &kDelaunay, &kJet, &kAso, &kNormalRegression};
  return kStrategies;
}

const Strategy* FindStrategy(std::string_view name) {
  const auto strategies = Strategies();
  const auto found = std::find_if(strategies.begin(), strategies.end(),
                                  [name](const Strategy* strategy) { return strategy->name == name; });
  return found == strategies.end() ? nullptr : *found;
}

std::optional<double> ReachFactor(const EstimatorOptions& options) {
  if (options.is_automatic()) return std::nullopt;
  const Strategy& strategy = *FindStrategy(options.estimator);
  const auto* const count = std::get_if<NeighborCount>(&options.neighborhood);
  if ((count == nullptr ? 0 : count->count) < strategy.least_bounded_count) return std::nullopt;
  return strategy.reach_factor;
}

namespace {

template <typename IsNamed>
std::string JoinNames(IsNamed is_named) {
  std::string names;
  for (const Strategy* strategy : Strategies()) {
    if (!is_named(*strategy)) continue;
    if (!names.empty()) names += ", ";
    names += strategy->name;
  }
  return names;
}

}  // namespace

std::string StrategyNames() {
  return JoinNames([](const Strategy&) { return true; });
}

std::string ScaledStrategyNames() {
  return JoinNames([](const Strategy& strategy) { return strategy.start_scales != nullptr; });
}

}  // namespace curvd
