// How noisy the positions of a cloud are, by what jets leave of the heights of its sampled points
// (docs/numerics/automatic_choice.md, "Noise in the positions").
#pragma once

#include <optional>

#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// The standard deviation of the noise of positions, in the index's unit; none if nothing tells it. Thread-safe.
std::optional<double> PositionNoise(PilotPoints table);

// Whether that is known to be nothing beside the smallest neighborhoods. Thread-safe.
bool PositionsAreExact(PilotPoints table);

}  // namespace curvd
