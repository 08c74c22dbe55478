// Quantiles of values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/order_statistic.h"

namespace curvd {

// Returns the value at the place `share` times their number, rounded down, of the values in ascending order, and
// reorders them: about that share of the values is smaller. Takes O(n). REQUIRES: there are some, none of which is NaN;
// 0 <= share < 1.
inline double Quantile(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The same at the place `share` times one less than their number, rounded down, and without a change of the values.
inline double LowerQuantile(std::vector<double> values, double share) {
  return OrderStatistic(values, static_cast<size_t>(share * static_cast<double>(values.size() - 1)));
}

}  // namespace curvd
