// The middle one of values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace curvd {

// Returns the middle value, the larger one of two, and reorders the values. Takes O(n). REQUIRES: there are some, none
// of which is NaN.
inline double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace curvd
