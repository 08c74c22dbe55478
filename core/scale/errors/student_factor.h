// Intervals whose width is known from a few samples alone.
#pragma once

namespace curvd {

// How many times farther than 1.645 standard deviations nine in ten values lie, where the standard deviation is known
// from so many independent samples: the 95 % quantile of Student's distribution over that of the Gaussian one, by three
// terms of Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5, which are within 1.3 % from two samples
// on. REQUIRES: samples >= 1.
constexpr double StudentFactor(double samples) {
  const double inverse = 1.0 / samples;
  return 1.0 + inverse * (0.926 + inverse * (0.863 + inverse * 0.598));
}

}  // namespace curvd
