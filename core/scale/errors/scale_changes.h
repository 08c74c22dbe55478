// How far an estimate is off, told by how it changes from its scale to the next ones
// (docs/numerics/standard_errors.md).
#pragma once

#include <cstddef>

#include "core/estimators/scale_ladder.h"

namespace curvd {

// Sums over several points of how the estimates of one method change from scale to scale, and the error that they tell
// of. Scales follow each other by the method's compared_rungs.
class ScaleChanges {
 public:
  explicit ScaleChanges(size_t method) : method_(method) {}

  // Of one component of an estimate: its change to the next scale, and from there to the one after it.
  void Add(double first, double second) {
    squares_ += first * first;
    next_squares_ += second * second;
    products_ += first * second;
  }

  // The root mean square error over that of the change to the next scale: the smaller one of what two models say, each
  // of which tells too much of what the other is made for. 1 where nothing changes.
  // - Errors grow or shrink by the same factor from each scale to the next, and the correlation of two is a power of
  //   that of neighbors, at least 0.
  // - The errors are biases that grow as the method's order says, and noise that more neighbors average.
  double ErrorPerChange() const;

 private:
  double SquareByEvenGrowth() const;
  double SquareByBiasAndNoise() const;

  size_t method_;
  double squares_ = 0.0, next_squares_ = 0.0, products_ = 0.0;
};

// How many times larger a bias is at the next scale, in theory.
double BiasGrowth(size_t method);
// What share of the variance that noise makes is left at the next scale, in theory.
double VarianceLeft(size_t method);

}  // namespace curvd
