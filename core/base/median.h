// The middle one of values.
#pragma once

#include <vector>

#include "core/base/order_statistic.h"

namespace curvd {

// Returns the middle value, the larger one of two. Takes O(n). REQUIRES: there are some, none of which is NaN.
inline double Median(std::vector<double> values) { return OrderStatistic(values, values.size() / 2); }

}  // namespace curvd
