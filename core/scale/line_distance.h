// Lines on which scanners leave points.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot.h"

namespace curvd {

// How far the next line is from the one that the sampled point of the moment lies on, in the index's unit; 0: it lies
// on none, or even `largest_radius`, the largest neighborhood's, spans too few lines for cubic polynomials, so that
// there is nothing to prefer. REQUIRES: s.order, s.squared and the copies are those of the point.
double LineDistance(double largest_radius, const PilotScratch& s);

// The least radius of a neighborhood, in distances of lines, that tells the polynomials of a method. Across lines, a
// polynomial is told by one more of them than its degree; the outermost count for little.
constexpr double LeastRadiusOverLines(size_t method) {
  constexpr double kPerDegree = 0.5, kBeyond = 0.7;
  return kPerDegree * std::max(kScaleMethods[method].degree, 1U) + kBeyond;
}

}  // namespace curvd
