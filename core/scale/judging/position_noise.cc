#include "core/scale/judging/position_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/sample_medians.h"

namespace curvd {
namespace {

// The rung from which the residual of a jet of degree 4 tells the noise.
constexpr size_t kFirstToldRung = 2;
// Noise is told from the surface in neighborhoods that are so many times larger.
constexpr double kLeastRadiusOverNoise = 4.0;
// Noise that is at most this share of the radius of the first rung leaves positions exact.
constexpr double kMostNoiseOfExactPositions = 1e-3;

}  // namespace

std::optional<double> PositionNoise(PilotPoints table) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t rung = kFirstToldRung; rung < kRungCount; ++rung) {
    const double residual = MedianOf(table, [rung](const PilotPoint& point) { return point.residual[rung]; });
    // Neighborhoods hardly larger than the noise leave its outer parts out; detail only adds to it.
    if (std::isfinite(residual) && kLeastRadiusOverNoise * residual <= MedianRadius(table, rung)) {
      least = std::min(least, residual);
    }
  }
  return std::isfinite(least) ? std::optional(least) : std::nullopt;
}

bool PositionsAreExact(PilotPoints table) {
  const std::optional<double> sigma = PositionNoise(table);
  return sigma.has_value() && *sigma <= kMostNoiseOfExactPositions * MedianRadius(table, 0);
}

}  // namespace curvd
