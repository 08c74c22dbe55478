#include "core/scale/errors/scale_changes.h"

#include <algorithm>
#include <cmath>

namespace curvd {

double ScaleChanges::ErrorPerChange() const {
  if (!(squares_ > 0.0)) return 1.0;
  return std::sqrt(std::min(SquareByEvenGrowth(), SquareByBiasAndNoise()));
}

// With errors e, g e and g² e at three scales and correlations r, r and r², the mean squares of both changes and their
// mean product are three equations for e², g and r. Without a correlation, the first change is the sum of two errors.
double ScaleChanges::SquareByEvenGrowth() const {
  const double apart = squares_ - next_squares_;
  const double common = std::sqrt(apart * apart + 4.0 * products_ * products_) - 2.0 * products_;
  return squares_ / std::min(common, squares_ + next_squares_);
}

// Averages over neighborhoods that grow change independently from scale to scale, so that what the changes have in
// common is bias.
double ScaleChanges::SquareByBiasAndNoise() const {
  const double growth = BiasGrowth(method_);
  const double bias = std::clamp(products_ / (growth * squares_), 0.0, 1.0);
  return bias / ((growth - 1.0) * (growth - 1.0)) + (1.0 - bias) / (1.0 - VarianceLeft(method_));
}

// Radii grow as the root of the count. The scales of all methods but jets of degree 6 are as far apart as makes biases
// double: two rungs where they grow as the square of the radius, one where they grow as its fourth power.
double BiasGrowth(size_t method) {
  const ScaleMethod& one = kScaleMethods[method];
  return std::max(2.0, std::exp2(0.25 * static_cast<double>(one.degree * one.compared_rungs)));
}

// The variance of first derivatives of normals goes with the count as count^-2, that of second ones of positions as
// count^-3.
double VarianceLeft(size_t method) {
  const ScaleMethod& one = kScaleMethods[method];
  return std::exp2((one.is_jet() ? -1.5 : -1.0) * static_cast<double>(one.compared_rungs));
}

}  // namespace curvd
