// Medians over the sampled points of a cloud.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Of those values of the points that are finite; infinity if there are none. `value` takes a point.
template <typename Value>
double MedianOf(PilotPoints table, const Value& value) {
  std::vector<double> values;
  values.reserve(table.size());
  for (const PilotPoint& point : table) {
    if (const double v = value(point); std::isfinite(v)) values.push_back(v);
  }
  return values.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(values));
}

// Of the neighborhoods of a rung, in the index's unit.
inline double MedianRadius(PilotPoints table, size_t rung) {
  return MedianOf(table, [rung](const PilotPoint& point) { return point.radius[rung]; });
}

}  // namespace curvd
