// Clocks and medians.
#pragma once

#include <time.h>

#include <algorithm>
#include <vector>

namespace curvd::bench {

inline double SecondsOf(clockid_t clock) {
  timespec now;
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double WallSeconds() { return SecondsOf(CLOCK_MONOTONIC); }
// Of all threads of this process. What others run on the machine disturbs it far less than the wall clock.
inline double CpuSeconds() { return SecondsOf(CLOCK_PROCESS_CPUTIME_ID); }

// The lower quantile of `values` at `fraction`. REQUIRES: values is not empty, 0 <= fraction < 1.
inline double Quantile(std::vector<double> values, double fraction) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}
inline double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

}  // namespace curvd::bench
