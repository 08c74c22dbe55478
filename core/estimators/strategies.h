// The table of strategies: every way in which this library makes curvature of a neighborhood.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/estimators/strategy.h"

namespace curvd {

// All of them, the default first, in an order that does not change.
std::span<const Strategy* const> Strategies();

// The strategy of that name, or nullptr.
const Strategy* FindStrategy(std::string_view name);

// How far from a point its estimate looks at most, in units of the radius that it reports; nothing where that has no
// bound. REQUIRES: options.Validate() is OK.
std::optional<double> ReachFactor(const EstimatorOptions& options);

// All names, for messages: "avg-hexagram, hexagram, ...".
std::string StrategyNames();

// The names of those that take several scales.
std::string ScaledStrategyNames();

}  // namespace curvd
