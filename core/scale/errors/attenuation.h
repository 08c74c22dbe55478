// How much of the curvature's variation smoothing takes away, as the sampled points of a cloud show it
// (docs/numerics/standard_errors.md, "Attenuation").
#pragma once

#include <array>
#include <cstddef>

#include "core/scale/errors/shape_parts.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Larger neighborhoods draw H, k1 and k2 towards their means over the cloud: where they are extreme, an estimate lacks
// the most. The error is told by the curvature itself, which every point has, and not by the few samples near it.
struct Attenuation {
  // Of one quantity.
  struct OfPart {
    double slope = 0.0;  // what is lost, per what the estimate differs from the mean; 0 to 1
    double mean = 0.0;   // over the samples

    // What an estimate of this value is expected to lack.
    double LostAt(double value) const { return slope * (value - mean); }
  };

  std::array<OfPart, kTurnPart> of{};  // H, k1 and k2, in the order of ShapePart
};

// A slope is 0 unless the samples show it: it must be twice its own standard error. Thread-safe. REQUIRES: `choice` was
// made of `table`, and has scores.
Attenuation FindAttenuation(PilotPoints table, const ScaleChoice& choice);

}  // namespace curvd
