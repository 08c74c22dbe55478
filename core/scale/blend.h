// Averages estimates of one point.
#pragma once

#include <array>

#include "core/estimators/curvature_field.h"

namespace curvd {

// Usage: Add each estimate with its weight, then Finish. In doubles.
class Blend {
 public:
  // An estimate whose status is not kOk has no weight, whatever the weights are: of the shape operator, and of the
  // Gaussian curvature. One of weight 0 counts for nothing, nor does its radius. REQUIRES: they are not negative, and
  // `weight` is 0 only if both are.
  void Add(const PointCurvature& estimate, double weight, double gaussian_weight);
  // The weighted mean of the shape operators, as curvature: H is the mean of the mean curvatures, k1, k2, d1 and d2
  // come of the mean tensor, and lie in the plane normal to the mean normal. The radius is the largest: how far any of
  // them looked. If no estimate had a weight, the status of the one that was to have the largest.
  PointCurvature Finish() const;
  // Of the shape operators so far.
  double weight() const { return weight_; }

  // Of the mean curvatures so far. REQUIRES: weight() > 0.
  double mean() const { return mean_ / weight_; }

  // By how much the estimates differ from their average: weighted standard deviations. 0 where one alone has a weight.
  struct Spread {
    double mean, k1, k2;
  };
  Spread spread() const;

 private:
  double weight_ = 0.0, gaussian_weight_ = 0.0, mean_ = 0.0, gaussian_ = 0.0;
  // Weighted sums of what H, k1 and k2 are beyond those of the first estimate, and of their squares.
  std::array<double, 3> first_{}, beyond_{}, squares_{};
  std::array<double, 6> tensor_{};  // xx xy xz yy yz zz
  std::array<double, 3> normal_{};
  float radius_ = 0.0f;
  double most_refused_ = -1.0;
  PointCurvature refused_ = UndefinedCurvature(PointStatus::kTooFewNeighbors);
};

}  // namespace curvd
