// What the sampled points of a cloud show of the errors of a choice, each for itself.
#pragma once

#include <span>
#include <vector>

#include "core/scale/errors/shape_parts.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Squared errors of the averaged estimate at a sampled point, in units of 1 / the index's length. Each is a sample of
// what is expected, and means something only on average over several points; those that are products of two halves may
// be negative.
struct ErrorSample {
  bool is_known = false;  // else there was no estimate, or nothing to compare it with
  ShapeParts noise{};  // variance, as two halves of the neighborhoods show it, where they have estimates; else `detail`
                       // holds it
  ShapeParts detail{};  // what smoothing takes away, as the next scale shows it
  ShapeParts place{};   // what noise in the positions makes by moving the point along the surface
  // From noise in the positions: of H, and of half of k2 - k1.
  double noise_bias = 0.0, half_noise_bias = 0.0;
  double lean = 0.0;   // not squared: the error of H, with its sign, as the next scale shows it
  double floor = 0.0;  // not squared: the least error that can be told
};

// One for each point of the table. `variance_factors` has one for each chosen candidate: the noise variance of the
// estimates that are made is so many times that of the candidate's rung, which differs where the number of neighbors is
// fixed and no rung. Thread-safe. REQUIRES: `choice` was made of `table`, and has scores.
std::vector<ErrorSample> SampleErrors(PilotPoints table, const ScaleChoice& choice,
                                      std::span<const double> variance_factors);

}  // namespace curvd
